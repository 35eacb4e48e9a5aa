//! The example client against the real program.

use crate::process::Server;

#[path = "../../examples/adaptive.rs"]
#[expect(dead_code, reason = "its main is the example's")]
mod adaptive;

#[test]
fn the_example_client_walks_and_what_it_is_promised_holds() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path());
    let mut told = Vec::new();
    let compared = adaptive::walk(&server.address, "living", 3, &mut told).unwrap();
    let told = String::from_utf8(told).unwrap();
    assert!(compared.kept > 1_000 && compared.changed > 1_000, "{compared:?}");
    assert!(told.starts_with("generation 1: bred in ") && told.contains("\ngeneration 3: ") && told.ends_with("the promise held\n"), "{told}");
    let players = server.get("/worlds/living/players");
    assert_eq!(players, br#"{"players":[]}"#, "it has left");
    let nowhere = adaptive::walk(&server.address, "alps", 1, &mut Vec::new()).unwrap_err();
    assert_eq!(nowhere.to_string(), "nothing in this world adapts");
}
