//! The secret that signer and checker share.

use std::fmt;

use sha2::{Digest, Sha256};
use thiserror::Error;

/// Length of a key, bytes.
const LENGTH: usize = 32;
/// The shortest passphrase taken, characters: anyone who hears a signed frame can try passphrases at leisure.
const MIN_PASSPHRASE: usize = 8;

/// A signing key of 32 bytes. It never shows itself in logs.
#[derive(Clone, PartialEq, Eq)]
pub struct SigningKey([u8; LENGTH]);

/// Why a key file holds no key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum KeyError {
    /// Nothing in it.
    #[error("it is empty: put 32 random bytes, 64 hexadecimal digits or a passphrase into it")]
    Empty,
    /// A passphrase that is soon guessed.
    #[error("its passphrase has only {length} characters: take at least {MIN_PASSPHRASE}, better a sentence")]
    Short {
        /// Its length, characters.
        length: usize,
    },
    /// Neither 32 bytes nor text.
    #[error(
        "it holds {length} bytes that are no text: a key is 32 bytes, 64 hexadecimal digits or a passphrase"
    )]
    NotAKey {
        /// Its length, bytes.
        length: usize,
    },
    /// All zero: the value that means "no signing" in SETUP_SIGNING.
    #[error("the key is all zeroes, which means `no signing` in MAVLink: take another")]
    Zero,
}

impl SigningKey {
    /// The key that consists of these bytes.
    ///
    /// # Errors
    /// [`KeyError::Zero`].
    pub fn from_bytes(bytes: [u8; LENGTH]) -> Result<Self, KeyError> {
        if bytes == [0; LENGTH] { Err(KeyError::Zero) } else { Ok(Self(bytes)) }
    }

    /// The key that ground stations (Mission Planner, MAVProxy) make of a passphrase: its SHA-256.
    pub fn from_passphrase(passphrase: &str) -> Self {
        Self(Sha256::digest(passphrase.as_bytes()).into())
    }

    /// The key in a file: 64 hexadecimal digits, 32 bytes that are not all printable text, or else a passphrase.
    ///
    /// White space at the end of a text does not count.
    ///
    /// # Errors
    /// [`KeyError`] if it is none of these.
    pub fn from_file_contents(contents: &[u8]) -> Result<Self, KeyError> {
        let text = std::str::from_utf8(contents).ok().map(str::trim_end);
        match text.filter(|text| !text.chars().any(char::is_control)) {
            Some("") => Err(KeyError::Empty),
            Some(text) => match from_hex(text) {
                Some(bytes) => Self::from_bytes(bytes),
                None => match text.chars().count() {
                    length if length < MIN_PASSPHRASE => Err(KeyError::Short { length }),
                    _ => Ok(Self::from_passphrase(text)),
                },
            },
            None => match contents.try_into() {
                Ok(bytes) => Self::from_bytes(bytes),
                Err(_) => Err(KeyError::NotAKey { length: contents.len() }),
            },
        }
    }

    /// The bytes, for SETUP_SIGNING.
    pub fn bytes(&self) -> &[u8; LENGTH] {
        &self.0
    }
}

fn from_hex(text: &str) -> Option<[u8; LENGTH]> {
    let digits: Option<Vec<u8>> = text.chars().map(|c| c.to_digit(16).map(|digit| digit as u8)).collect();
    let bytes: Vec<u8> =
        digits?.chunks(2).map(|pair| pair.iter().fold(0, |all, digit| all << 4 | digit)).collect();
    if text.len() == 2 * LENGTH { bytes.try_into().ok() } else { None }
}

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SigningKey(secret)")
    }
}
