//! The gallery: runs every scenario and tutorial and writes `docs/gallery.md` with a picture of each.
//!
//! ```text
//! cargo example gallery              all of them, half a minute
//! cargo example gallery bearing      only those whose path contains the word; the others keep their pictures
//! ```
//!
//! `tests/gallery.rs` checks that every script is in the gallery with a picture.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use conserva::script::{Ink, Session, Settings, Silent, home};

/// Scripts in the order of the gallery, each with the file of its run that is shown.
const SHOWN: &[(&str, &str)] = &[
    ("scenarios/bearing", "bearing.svg"),
    ("scenarios/bearing_integrators", "studies/integrators-drift.svg"),
    ("scenarios/hertz", "hertz-20.svg"),
    ("scenarios/ironing", "ironing.svg"),
    ("scenarios/three_point_bending", "bent.svg"),
    ("scenarios/tuning_fork", "fork.svg"),
    ("scenarios/lees_frame", "frame.svg"),
    ("scenarios/pegs", "energies.svg"),
    ("scenarios/crushed_hose", "hose-gap.svg"),
    ("scenarios/bouncing_ring", "ring.svg"),
    ("scenarios/slider_crank", "slider_crank.svg"),
    ("scenarios/roller_bearing", "roller_bearing.png"),
    ("scenarios/newtons_cradle", "newtons_cradle.svg"),
    ("scenarios/cam_and_follower", "cam_and_follower.svg"),
    ("scenarios/geneva_drive", "geneva_drive.svg"),
    ("scenarios/door_closer", "door_closer.svg"),
    ("scenarios/washing_machine", "swing.svg"),
    ("scenarios/wheel_over_kerb", "wheel_over_kerb.png"),
    ("scenarios/balloon", "balloon.svg"),
    ("scenarios/colliding_rings", "rings.svg"),
    ("scenarios/ring_on_ring", "rings.svg"),
    ("scenarios/cylinder_in_ring", "cylinder.svg"),
    ("scenarios/press_fit_methods", "press_fit.svg"),
    ("scenarios/fibre_cell", "sheared.svg"),
    ("scenarios/contact_patch", "patch.svg"),
    ("scenarios/seal", "seal.svg"),
    ("scenarios/rubber_block", "law.svg"),
    ("scenarios/bracket", "pulled.svg"),
    ("scenarios/cooks_membrane", "rubber_mean/rubber mean.svg"),
    ("scenarios/patch_test", "patch.svg"),
    ("scenarios/two_bars", "bars.svg"),
    ("scenarios/bar_impact", "history.svg"),
    ("scenarios/calibration", "calibration.svg"),
    ("scenarios/braking_rings", "braking_rings.svg"),
    ("scenarios/incline", "incline.svg"),
    ("scenarios/rolling_disk", "rolling_disk.svg"),
    ("scenarios/capstan", "capstan.svg"),
    ("scenarios/clutch", "clutch.svg"),
    ("scenarios/driven_bearing", "power.svg"),
    ("scenarios/snap_fit", "force.svg"),
    ("scenarios/wedge", "wedge.svg"),
    ("scenarios/fretting", "shear.svg"),
    ("scenarios/stick_slip", "stick_slip.svg"),
    ("scenarios/pile", "pile.svg"),
    ("scenarios/tumbling_block", "block.svg"),
    ("scenarios/tumbling_block_3d", "brick.svg"),
    ("scenarios/bearing_3d", "energy.svg"),
    ("scenarios/thrown_bricks", "bricks.svg"),
    ("scenarios/ball_in_bowl", "bowl.png"),
    ("scenarios/roller", "roller.png"),
    ("scenarios/crossing_tubes", "tubes.png"),
    ("scenarios/hertz_ball", "ball.png"),
    ("scenarios/brick_wall", "wall.png"),
    ("scenarios/gears", "gears.png"),
    ("scenarios/o_ring", "o_ring.png"),
    ("scenarios/snap_ring", "snap_ring.png"),
    ("scenarios/screw_and_nut", "screw.png"),
    ("tutorials/01_first_body", "plate.svg"),
    ("tutorials/02_first_contact", "buffer.svg"),
    ("tutorials/03_reading_the_ledger", "energies.svg"),
    ("tutorials/04_comparing_integrators", "energies.svg"),
    ("tutorials/05_writing_a_test", "history.svg"),
    ("tutorials/06_a_load_as_a_closure", "history.svg"),
    ("tutorials/07_a_parameter_study", "deflection.svg"),
    ("tutorials/08_why_a_step_failed", "impact.svg"),
    ("tutorials/09_friction", "energies.svg"),
    ("tutorials/10_which_integrator", "studies/integrators-work.svg"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pictures = repository.join("docs/images/gallery");
    std::fs::create_dir_all(&pictures)?;
    let chosen = std::env::args().nth(1).unwrap_or_default();
    let results = std::env::temp_dir().join(format!("conserva-gallery-{}", std::process::id()));
    for (script, shown) in SHOWN.iter().filter(|(script, _)| script.contains(&chosen)) {
        let begun = std::time::Instant::now();
        let picture = run(&repository.join("scripts").join(script).with_extension("rhai"), &results.join(script), shown)?;
        std::fs::copy(picture, pictures.join(picture_name(script, shown)))?;
        println!("{script}: {:.1} s", begun.elapsed().as_secs_f64());
    }
    if results.exists() {
        std::fs::remove_dir_all(results)?;
    }
    std::fs::write(repository.join("docs/gallery.md"), page(repository)?)?;
    Ok(())
}

/// Runs a script; returns the path of the displayed file.
fn run(script: &Path, output: &Path, shown: &str) -> Result<PathBuf, Box<dyn Error>> {
    let settings = Settings { output: Some(output.to_path_buf()), ..Settings::default() };
    let mut session = Session::new(settings, home(script), Rc::new(Silent)).map_err(|error| error.render(Ink::Plain))?;
    match session.run_file(script).error {
        Some(error) => Err(error.render(Ink::Plain).into()),
        None => Ok(output.join(shown)),
    }
}

/// Name of a script's picture in the gallery's folder.
fn picture_name(script: &str, shown: &str) -> String {
    let ending = shown.rsplit('.').next().unwrap_or("svg");
    format!("{}.{ending}", script.rsplit('/').next().unwrap_or(script))
}

/// The gallery's text: each script's first words beside its picture.
fn page(repository: &Path) -> Result<String, Box<dyn Error>> {
    let mut page = String::from(
        "# Gallery\n\nEvery scenario and tutorial in `scripts/`, with a picture that it makes. `cargo example gallery` \
         runs them all and writes this page.\n",
    );
    for (folder, title) in [("scenarios", "Scenarios"), ("tutorials", "Tutorials")] {
        let _ = writeln!(page, "\n## {title}");
        for (script, shown) in SHOWN.iter().filter(|(script, _)| script.starts_with(folder)) {
            let text = std::fs::read_to_string(repository.join("scripts").join(script).with_extension("rhai"))?;
            let words = first_words(&text);
            let (name, picture) = (script.rsplit('/').next().unwrap_or(script), picture_name(script, shown));
            let _ = writeln!(page, "\n### [{name}](../scripts/{script}.rhai)\n\n{words}\n\n![{name}](images/gallery/{picture})");
        }
    }
    Ok(page)
}

/// First paragraph of the initial comment of a script; for a tutorial, the text after its title as well.
fn first_words(text: &str) -> String {
    let comment = text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim);
    let paragraphs: Vec<String> = comment
        .collect::<Vec<_>>()
        .split(|line| line.is_empty())
        .filter(|lines| !lines.is_empty())
        .map(|lines| lines.join(" "))
        .filter(|words| !words.starts_with("conserva ") && !words.starts_with("Run it"))
        .collect();
    let count = if text.starts_with("// Tutorial") { 2 } else { 1 };
    paragraphs.into_iter().take(count).collect::<Vec<_>>().join(" ")
}
