//! Installs packages of Debian, only when the user asked for it.

use std::process::{Command, Stdio};

use super::need::is_installed;

/// Whether packages may be installed, and whether their lists are up to date.
pub(super) struct Packages {
    allowed: bool,
    updated: bool,
}

impl Packages {
    pub(super) fn new(allowed: bool) -> Self {
        Self {
            allowed,
            updated: false,
        }
    }

    /// Installs packages.
    ///
    /// # Errors
    /// Why it did not.
    pub(super) fn install(&mut self, packages: &[&str]) -> Result<(), String> {
        if packages.is_empty() || !self.allowed {
            return Err("nothing was installed".into());
        }
        if !is_installed("apt-get") {
            return Err("there is no apt-get to install packages".into());
        }
        if !is_root() {
            return Err("only root can install packages".into());
        }
        println!("installing {}", packages.join(" "));
        if !self.updated {
            self.updated = true;
            // The lists that are there may do.
            let _ = apt_get(&["update"]);
        }
        let mut arguments = vec!["install", "--no-install-recommends"];
        arguments.extend_from_slice(packages);
        if apt_get(&arguments) {
            Ok(())
        } else {
            Err(format!("apt-get could not install {}", packages.join(" ")))
        }
    }
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

/// Whether it ended without a failure; it says itself what went wrong.
fn apt_get(arguments: &[&str]) -> bool {
    let status = Command::new("apt-get")
        .arg("-qq")
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        // A page of progress; what goes wrong is on the standard error.
        .stdout(Stdio::null())
        .status();
    status.is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_installed_unasked() {
        let refused = Packages::new(false).install(&["no-such-package"]);
        assert_eq!(refused, Err("nothing was installed".into()));
    }
}
