//! What can be checked of a text by a machine.

/// Names of the variants of an enum in its source.
#[allow(dead_code, reason = "the test of the help texts has no use for it")]
pub(crate) fn variants(source: &str, name: &str) -> Vec<String> {
    let start = source
        .find(&format!("pub enum {name} {{"))
        .unwrap_or_else(|| panic!("no enum {name}"));
    let body = &source[start..];
    let body = &body[..body.find("\n}").expect("the end of the enum")];
    body.lines()
        .skip(1)
        .filter_map(|line| line.strip_prefix("    "))
        .filter(|line| line.starts_with(|letter: char| letter.is_ascii_uppercase()))
        .map(|line| {
            line.chars()
                .take_while(char::is_ascii_alphanumeric)
                .collect()
        })
        .collect()
}

/// Every variant of an enum is among these events, and each is told in words that a user understands.
#[allow(dead_code, reason = "the test of the help texts has no use for it")]
pub(crate) fn events_are_plain<E: core::fmt::Debug>(
    (source, name): (&str, &str),
    events: &[E],
    words: impl Fn(&E) -> String,
) {
    for variant in variants(source, name) {
        let mut events = events.iter();
        let is_there = events.any(|event| format!("{event:?}").starts_with(&variant));
        assert!(is_there, "{variant} is not in this test");
    }
    for event in events {
        let text = words(event);
        let flaws = flaws_of_a_message(&text);
        assert!(flaws.is_empty(), "{text}: {flaws:?}");
        assert!(!text.contains("does not know"), "{event:?}");
    }
}

/// What is wrong with any text that a user reads.
pub(crate) fn flaws(text: &str) -> Vec<String> {
    let mut flaws = Vec::new();
    let words: Vec<&str> = text
        .split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '-' || letter == '.'))
        .filter(|word| !word.is_empty())
        .map(|word| word.trim_end_matches(['.', '-']))
        .collect();
    for word in &words {
        // Numbers of the project's own list of doubts, as D44, M22, Z40.
        if let Some(number) = word.strip_prefix(['D', 'M', 'Z'])
            && (1..=2).contains(&number.len())
            && number.bytes().all(|byte| byte.is_ascii_digit())
        {
            flaws.push(format!("{word} means nothing to a user"));
        }
        // The largest number of 64 bits in place of "never".
        if word.starts_with("184467440737") {
            flaws.push(format!("{word} is no number"));
        }
    }
    for pair in words.windows(2) {
        let is_plural = is_word(pair[1])
            && pair[1].len() > 3
            && pair[1].ends_with('s')
            && !pair[1].ends_with("ss");
        if pair[0] == "1" && is_plural && !["axis", "bus", "status"].contains(&pair[1]) {
            flaws.push(format!("\"1 {}\"", pair[1]));
        }
    }
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        for pair in words.windows(2) {
            if pair[0] == pair[1] && pair[0].len() > 1 && is_word(pair[0]) {
                flaws.push(format!("\"{} {}\"", pair[0], pair[1]));
            }
        }
    }
    // The library of the command line has one of its own.
    if text.replace("subcommand(s)", "").contains("(s)") {
        flaws.push("\"(s)\" leaves the number to the reader".to_owned());
    }
    flaws
}

fn is_word(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_lowercase())
}

/// What is wrong with a message of one line, which has no columns and no examples.
#[allow(dead_code, reason = "the test of the help texts has no use for it")]
pub(crate) fn flaws_of_a_message(text: &str) -> Vec<String> {
    let mut flaws = flaws(text);
    for leftover in ["{", "}", "Some(", "None", "::", "  ", "Unknown("] {
        if text.contains(leftover) {
            flaws.push(format!("{leftover:?} is for programmers"));
        }
    }
    // "axis 0": users know drives by their ids.
    let is_index = |rest: &str| rest.starts_with(|digit: char| digit.is_ascii_digit());
    if text.split("axis ").skip(1).any(is_index) {
        flaws.push("an axis by its index".to_owned());
    }
    if text.trim().is_empty() {
        flaws.push("nothing".to_owned());
    }
    flaws
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_flaw_is_seen() {
        for flawed in [
            "as D44 says",
            "see Z40.",
            "18446744073709551 ms old",
            "1 drives answer",
            "the the drive",
            "2 drive(s)",
        ] {
            assert_eq!(flaws(flawed).len(), 1, "{flawed}: {:?}", flaws(flawed));
        }
        for flawed in ["axis 0 is lost", "Some(3) frames", "two  spaces", ""] {
            assert!(!flaws_of_a_message(flawed).is_empty(), "{flawed}");
        }
        for fine in [
            "1 drive answers, 2 drives do not",
            "1 ms, 1 rpm, 1 us",
            "DYN2 drives at 1000 kbit/s",
            "drive 3: alarm",
            "1 axis",
        ] {
            assert_eq!(flaws_of_a_message(fine), [""; 0], "{fine}");
        }
    }
}
