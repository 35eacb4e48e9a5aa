//! Signed addresses: a world read without a key, until a time.

use super::error::ApiError;
use crate::store::is_signature;
use axum::{extract::Request, http::Uri};
use std::time::{SystemTime, UNIX_EPOCH};

/// The parameters of a signed address.
const PARAMETERS: [&str; 3] = ["key", "expires", "signature"];

/// What a signed address adds to the address of what it asks for: `key=ID&expires=SECONDS&signature=HEX`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Signed {
    /// All three as they came, for the links of an answer.
    pub text: String,
    key: String,
    expires: String,
    signature: String,
}

impl Signed {
    /// Takes the parameters out of a request's address, so that what they sign is read as ever; `None` if there is no signature.
    pub(super) fn take(request: &mut Request) -> Result<Option<Self>, ApiError> {
        let name = |part: &str| part.split_once('=').map_or_else(|| part.to_owned(), |(name, _)| name.to_owned());
        let query = request.uri().query().unwrap_or_default();
        if !query.split('&').any(|part| name(part) == "signature") {
            return Ok(None);
        }
        let (own, rest): (Vec<&str>, Vec<&str>) = query.split('&').partition(|part| PARAMETERS.contains(&name(part).as_str()));
        let value = |wanted: &str| {
            let mut values = own.iter().filter_map(|part| part.split_once('=')).filter(|(name, _)| *name == wanted);
            values.next().filter(|_| values.next().is_none()).map(|(_, value)| value.to_owned())
        };
        let ([Some(key), Some(expires), Some(signature)], 3) = (PARAMETERS.map(value), own.len()) else {
            return Err(ApiError::Unauthorized("A signed address has key, expires and signature, once each."));
        };
        let (text, path) = (own.join("&"), request.uri().path());
        let address = if rest.is_empty() { path.to_owned() } else { format!("{path}?{}", rest.join("&")) };
        // What is left of an address is one.
        *request.uri_mut() = address.parse::<Uri>().map_err(|error| ApiError::internal("reading an address", &error))?;
        Ok(Some(Self { text, key, expires, signature }))
    }

    /// Whether the holder of one of the keys, given by the hashes of their secrets, lets what stands under a path be read now.
    pub(super) fn check<'a>(&self, path: &str, mut hashes: impl Iterator<Item = &'a String>) -> Result<(), ApiError> {
        let world = path.strip_prefix("/worlds/").and_then(|rest| rest.split(['/', '@']).next()).filter(|world| !world.is_empty());
        let world = world.ok_or(ApiError::Unauthorized("An address is signed for what stands under one world."))?;
        let hash = hashes.find(|hash| hash.starts_with(&self.key) && self.key.len() == ID_DIGITS);
        let hash = hash.ok_or(ApiError::Unauthorized("There is no such key as the address is signed with, or it was taken back."))?;
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let expires = self.expires.parse::<u64>().map_err(|_not_a_number| ApiError::Unauthorized("expires must be seconds since 1970-01-01."))?;
        if !is_signature(hash, world, expires, &self.signature) {
            return Err(ApiError::Unauthorized("The signature is not that of this world, time and key."));
        }
        if expires <= now {
            return Err(ApiError::Unauthorized("The time for which the address was signed is over."));
        }
        Ok(())
    }
}

/// Hex digits of a key's id.
const ID_DIGITS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{hash_of, sign};
    use axum::body::Body;

    fn taken(address: &str) -> (Result<Option<Signed>, String>, String) {
        let mut request = Request::builder().uri(address).body(Body::empty()).expect("an address");
        let signed = Signed::take(&mut request).map_err(|error| format!("{error:?}"));
        (signed, request.uri().to_string())
    }

    #[test]
    fn parameters_are_taken_out_and_kept() {
        let (signed, rest) = taken("/worlds/a/web/terrarium?key=12345678&live=1&signature=ab&expires=5");
        assert_eq!(signed.expect("whole").expect("signed").text, "key=12345678&signature=ab&expires=5");
        assert_eq!(rest, "/worlds/a/web/terrarium?live=1");
        assert_eq!(taken("/programmes?key=x"), (Ok(None), "/programmes?key=x".to_owned()), "another's parameter");
        assert_eq!(taken("/a?signature=b&key=1&expires=2").1, "/a");
        for wrong in ["/a?signature=b", "/a?signature=b&key=1&expires=2&key=1", "/a?signature&key=1&expires=2"] {
            assert!(taken(wrong).0.is_err(), "{wrong}");
        }
    }

    #[test]
    fn one_world_is_signed_until_a_time() {
        let hashes = [hash_of("other"), hash_of("secret")];
        let check = |path: &str, world: &str, expires: u64, change: fn(String) -> String| {
            let signature = change(sign(&hashes[1], world, expires));
            let (signed, _) = taken(&format!("{path}?key={}&expires={expires}&signature={signature}", &hashes[1][..ID_DIGITS]));
            let answer = signed.expect("whole").expect("signed").check(path, hashes.iter());
            answer.map_err(|error| if let ApiError::Unauthorized(why) = error { why.split(' ').next_back().unwrap_or_default() } else { "?" })
        };
        let (later, same) = (u64::MAX, |text: String| text);
        assert_eq!(check("/worlds/alps/web/terrarium/1/0/0.png", "alps", later, same), Ok(()));
        assert_eq!(check("/worlds/alps@abc/style.json", "alps", later, same), Ok(()));
        assert_eq!(check("/worlds/alps", "alps", 1_000_000, same), Err("over."));
        assert_eq!(check("/worlds/alps2", "alps", later, same), Err("key."));
        assert_eq!(check("/worlds", "", later, same), Err("world."));
        assert_eq!(check("/worlds/alps", "alps", later, |text| text + "0"), Err("key."));
        assert_eq!(check("/worlds/alps", "alps", later, |_| "é".to_owned()), Err("key."));
    }
}
