//! The family of the example of `can-motion`, with its own simulated drive.
