//! Names in addresses.

/// Checks that a text can stand in an address: `[a-z0-9][a-z0-9-]{0,62}`. `noun` says what it would name, as in "a name".
///
/// # Errors
/// With what is wrong and what would be right.
pub fn check_name(noun: &str, text: &str) -> Result<(), String> {
    let plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit();
    if text.len() <= 63 && text.bytes().next().is_some_and(plain) && text.bytes().all(|b| plain(b) || b == b'-') {
        return Ok(());
    }
    let shown: String = text.chars().take(64).collect();
    Err(format!("{noun} is 1 to 63 of a … z, 0 … 9 and -, the first not -; got {shown:?}{}", if shown.len() < text.len() { "…" } else { "" }))
}
