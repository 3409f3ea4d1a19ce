//! Eye and head tracker decoders: bytes in, samples out.
#![no_std]
#![forbid(unsafe_code)]
