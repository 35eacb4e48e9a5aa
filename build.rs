//! Builds again when the viewer was built again: files that are new in the folder would not be seen otherwise.

fn main() {
    println!("cargo::rerun-if-changed=web/dist");
}
