//! The tool and a bench as two processes that talk over a pseudo-terminal, as users run them.

mod bench;
mod commission;
mod documents;
mod power;
mod run;
mod serial;
