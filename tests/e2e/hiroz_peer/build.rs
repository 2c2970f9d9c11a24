//! Writes the types of `simulation_interfaces`, which hiroz-msgs has not, with the generator of hiroz.

use std::{env, error::Error, path::Path};

const PACKAGE: &str = "simulation_interfaces";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed={PACKAGE}");
    env::set_var("HIROZ_MSG_PATH", Path::new(&env::var("CARGO_MANIFEST_DIR")?).join(PACKAGE));
    hiroz_codegen::generate_user_messages(Path::new(&env::var("OUT_DIR")?), false)?;
    Ok(())
}
