//! Prints one line for every file given: what it holds, or why it cannot be read.
//!
//! ```sh
//! cargo run --release -p pc-io --example inspect -- scan.ply model.json
//! ```

use std::env;
use std::time::Instant;

use pc_io::ReadOptions;

fn main() {
    for path in env::args_os().skip(1) {
        let start = Instant::now();
        match pc_io::read(&path, &ReadOptions::default()) {
            Ok(loaded) => println!("{} ({:.1} ms)", loaded.report, start.elapsed().as_secs_f64() * 1e3),
            Err(error) => println!("error: {error}"),
        }
    }
}
