//! Rebuilds the program when a published study changes: the compiler doesn't know of files that are new among them.

fn main() {
    println!("cargo::rerun-if-changed=../../studies");
}
