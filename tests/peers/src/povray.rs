//! POV-Ray, on scenes that both can describe: a dome master of mirror animals, and a
//! ball that takes light apart.

use super::clock::children_seconds;
use super::command::{Shisen, run};
use super::contender::{Subject, locked};
use super::measure::{Timed, in_turns};
use super::report::{Report, Row};
use glam::{DVec3, Vec3};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::{Light, Scene, Shape};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Reflections and refractions after one another, in both.
const DEPTH: u32 = 5;

/// Wavelengths, in both.
const WAVELENGTHS: u32 = 7;

/// A picture that both render.
struct Picture {
    name: &'static str,
    size: u32,
    /// The arguments of ours.
    arguments: Vec<String>,
    /// POV-Ray's description.
    description: String,
}

/// Returns the version of POV-Ray.
fn version(povray: &Path) -> String {
    let output = Command::new(povray).arg("--version").output();
    let said = output.map_or(Vec::new(), |output| [output.stdout, output.stderr].concat());
    let said = String::from_utf8_lossy(&said);
    let mut words = said.split_whitespace();
    words
        .find(|word| word.starts_with(|c: char| c.is_ascii_digit()))
        .map_or(String::new(), |word| word.trim_end_matches(':').to_owned())
}

/// Renders both pictures by both programs in turns: processor seconds of the whole programs,
/// with one thread and one sample a pixel.
pub fn measure(
    shisen: &Shisen,
    povray: &Path,
    subject: &Subject,
    size: u32,
    out: &Path,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let version = version(povray);
    for picture in [dome(subject, size, out)?, ball(size, out)?] {
        let ours = out.join(format!("{}-shisen", picture.name));
        let description = out.join(format!("{}.pov", picture.name));
        std::fs::write(&description, &picture.description)?;
        let theirs = out.join(format!("{}-povray.png", picture.name));
        let call_ours = || -> Result<_, Box<dyn Error>> {
            let mut command = shisen.command(&picture.arguments);
            command.arg("--depth").arg(DEPTH.to_string());
            command
                .args(["--samples", "1", "--threads", "1", "--quiet", "--out"])
                .arg(&ours);
            run(&mut command)
        };
        let call_theirs = || {
            let mut command = Command::new(povray);
            command
                .args(["+WT1", "-A", "-D", "-P", "+FN8", "-GA"])
                .arg(format!("+W{}", picture.size))
                .arg(format!("+H{}", picture.size))
                .arg(format!("+I{}", description.display()))
                .arg(format!("+O{}", theirs.display()));
            run(&mut command)
        };
        let times = in_turns(&[true, false], report.rounds, |&is_ours| {
            let start = children_seconds();
            let _ = if is_ours {
                call_ours()?
            } else {
                call_theirs()?
            };
            Ok::<_, Box<dyn Error>>((children_seconds() - start, ()))
        })?;
        let row = |peer: &str, version: &str, mode: &str, time: &Timed<()>| Row {
            subject: picture.name.to_owned(),
            what: format!("{0} by {0} pixels", picture.size),
            peer: peer.to_owned(),
            mode: mode.to_owned(),
            version: version.to_owned(),
            value: time.median(),
            unit: "cpu s",
            default_ratio: Some(time.ratio_to(&times[0])),
            ..Row::of_part("whole pictures, one thread")
        };
        report.rows.extend([
            row("Shisen", &locked("shisen"), "default build", &times[0]),
            row("POV-Ray", &version, "", &times[1]),
        ]);
        let ratio = times[1].ratio_to(&times[0]);
        report.at_least(format!("{}: Shisen / POV-Ray", picture.name), ratio, 10.0);
    }
    Ok(())
}

/// POV-Ray's frame has its third axis the other way round.
fn vector(v: DVec3) -> String {
    format!("<{}, {}, {}>", v.x, v.y, -v.z)
}

fn colour(c: [f32; 3]) -> String {
    format!("rgb <{}, {}, {}>", c[0], c[1], c[2])
}

/// Returns the beginning of every description.
fn settings() -> String {
    format!(
        "#version 3.7;\nglobal_settings {{ assumed_gamma 1.0 max_trace_level {} adc_bailout 1/1024 }}\n",
        DEPTH + 1
    )
}

/// Scene A around a dome's centre.
fn dome(subject: &Subject, size: u32, out: &Path) -> Result<Picture, Box<dyn Error>> {
    let scene = paper_scene(PaperScene::A, subject.mesh.clone())?;
    let mesh = out.join("dome-mesh.obj");
    subject.write_obj(&mesh)?;
    let arguments = format!("dome render --scene A --mapping true --size {size} --mesh");
    let mut arguments: Vec<_> = arguments.split(' ').map(str::to_owned).collect();
    arguments.push(mesh.to_string_lossy().into_owned());
    let mut text = settings();
    // A dome master has the front at the bottom, the right at the right.
    text += "camera { fisheye location <0, 0, 0> right <1, 0, 0> up <0, 0, -1> direction <0, 1, 0> angle 180 }\n";
    describe(&scene, &mut text);
    Ok(Picture {
        name: "dome",
        size,
        arguments,
        description: text,
    })
}

/// Writes a scene of meshes of one material under point lights.
fn describe(scene: &Scene, text: &mut String) {
    let sky = &scene.background;
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "sky_sphere {{ pigment {{ gradient y color_map {{ [0 {}] [0.5 {}] [1 {}] }} scale 2 translate -y }} }}",
        colour(sky.nadir),
        colour(sky.horizon),
        colour(sky.zenith)
    );
    for light in &scene.lights {
        if let Light::Point {
            position,
            colour: bright,
            ..
        } = light
        {
            let (position, bright) = (vector(*position), colour(*bright));
            let _ = writeln!(text, "light_source {{ {position} {bright} }}");
        }
    }
    for (number, mesh) in scene.meshes.iter().enumerate() {
        let normals = mesh.vertex_normals();
        let count = mesh.positions.len();
        let _ = writeln!(
            text,
            "#declare Mesh{number} = mesh2 {{\nvertex_vectors {{ {count}"
        );
        for position in &mesh.positions {
            let _ = writeln!(text, ", {}", vector(Vec3::from(*position).as_dvec3()));
        }
        let _ = writeln!(text, "}}\nnormal_vectors {{ {}", normals.len());
        for normal in normals.iter() {
            let _ = writeln!(text, ", {}", vector(Vec3::from(*normal).as_dvec3()));
        }
        let _ = writeln!(text, "}}\nface_indices {{ {}", mesh.triangles.len());
        for [a, b, c] in &mesh.triangles {
            let _ = writeln!(text, ", <{a}, {b}, {c}>");
        }
        *text += "}\n}\n";
    }
    for object in &scene.objects {
        let (Shape::Mesh(mesh), Some(material)) = (&object.shape, object.material) else {
            continue;
        };
        let material = &scene.materials[material];
        // Rows of its matrix are where axes go; the third is the other way round in both.
        let map = object.world_from_object;
        let axis = |v: DVec3| format!("{}, {}, {}", v.x, v.y, -v.z);
        let _ = writeln!(
            text,
            "object {{ Mesh{mesh} matrix <{}, {}, {}, {}> texture {{ pigment {{ {} }} finish {{ ambient {} diffuse 1 \
             specular {} roughness {} reflection {{ {} }} }} }} }}",
            axis(map.matrix3.x_axis),
            axis(map.matrix3.y_axis),
            axis(-map.matrix3.z_axis),
            axis(map.translation),
            colour(material.diffuse),
            colour(scene.ambient),
            material.specular[0],
            1.0 / material.shininess,
            colour(material.mirror)
        );
    }
}

/// Returns a ball of glass before a checkered wall that shines.
fn ball(size: u32, out: &Path) -> Result<Picture, Box<dyn Error>> {
    let scene: PathBuf = out.join("ball.toml");
    std::fs::write(
        &scene,
        "[materials.glass]\ndiffuse = [0, 0, 0]\ntransmission = [1, 1, 1]\nmedium = \"sf11\"\n\n\
         [materials.wall]\ndiffuse = [0, 0, 0]\nemission = [1, 1, 1]\ntexture = \"tiles\"\n\n\
         [textures.tiles]\nchecker = { colours = [[0.9, 0.9, 0.9], [0.1, 0.1, 0.1]] }\nrepeats = [16, 16]\n\n\
         [meshes.wall]\nbuiltin = \"square\"\n\n\
         [[object]]\nsphere = { radius = 1.2 }\nmaterial = \"glass\"\nposition = [0, 0, -4]\n\n\
         [[object]]\nmesh = \"wall\"\nmaterial = \"wall\"\nscale = 16\nposition = [0, 0, -8]\n\
         rotation_degrees = [0, 90, 0]\n",
    )?;
    let walls = out.join("ball-walls.toml");
    std::fs::write(
        &walls,
        "[[wall]]\nname = \"front\"\nlower_left = [-1, -1, -2]\nlower_right = [1, -1, -2]\nupper_left = [-1, 1, -2]\n",
    )?;
    // The picture that nobody compares stays small.
    let arguments = format!(
        "cave --eyes 1 --view-size 64x64 --size {size} --dispersion split \
         --wavelengths {WAVELENGTHS}"
    );
    let mut arguments: Vec<_> = arguments.split(' ').map(str::to_owned).collect();
    for (option, path) in [("--scene", scene), ("--walls", walls)] {
        arguments.extend([option.to_owned(), path.to_string_lossy().into_owned()]);
    }
    // SF11's index at 587.6 nm, and what it has at 400 to that at 700 nm.
    let description = settings()
        + &format!(
            "camera {{ location <0, 0, 0> right 2*x up 2*y direction 2*z }}\n\
             background {{ rgb 0 }}\n\
             sphere {{ <0, 0, 4>, 1.2 pigment {{ rgbt <1, 1, 1, 1> }} finish {{ ambient 0 diffuse 0 \
             reflection {{ 0, 1 fresnel on }} conserve_energy }} interior {{ ior 1.7847 dispersion 1.0421 \
             dispersion_samples {WAVELENGTHS} }} }}\n\
             box {{ <-8, -8, 0>, <8, 8, 0.001> pigment {{ checker rgb 0.9, rgb 0.1 }} finish {{ ambient 1 diffuse 0 }} \
             translate 8*z }}\n"
        );
    Ok(Picture {
        name: "ball",
        size,
        arguments,
        description,
    })
}
