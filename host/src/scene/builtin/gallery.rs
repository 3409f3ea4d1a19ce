//! A gallery: one room with every effect, made by the program.

mod shapes;
mod surfaces;

use crate::scene::environment::Environment;
use crate::scene::material::{Alpha, Cover, Graticule, Material, Microfacets, NormalMap};
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::{Channel, Clip, Course, Local};
use crate::scene::placement::{Normalisation, Placement};
use crate::scene::quadruped::quadruped;
use crate::scene::texture::{Pattern, Texture};
use crate::scene::{Background, Light, Object, Scene, Shape};
use glam::{DAffine3, DQuat, DVec3};
use shapes::{add_block, add_plate, branches, lathe, plate, rail};
use shisen_core::spectrum::Medium;

/// Height of the floor: metres.
const FLOOR: f64 = -1.5;

/// Seconds of one turn of the animal.
const TURN: f64 = 12.0;

/// A room while it is furnished.
#[derive(Default)]
struct Room {
    scene: Scene,
    /// All that is of plaster: rays look into one mesh rather than into ten.
    plaster: TriangleMesh,
}

impl Room {
    /// Adds a shape of a material.
    fn add(&mut self, shape: Shape, material: Material, place: DAffine3) -> &mut Object {
        let known = self.scene.materials.iter().position(|one| *one == material);
        let number = known.unwrap_or_else(|| {
            self.scene.materials.push(material);
            self.scene.materials.len() - 1
        });
        self.scene.objects.push(Object {
            material: Some(number),
            world_from_object: place,
            ..Object::new(shape)
        });
        self.scene.objects.last_mut().expect("just added")
    }

    fn mesh(&mut self, mesh: TriangleMesh, material: Material, place: DAffine3) -> &mut Object {
        self.scene.meshes.push(mesh);
        let shape = Shape::Mesh(self.scene.meshes.len() - 1);
        self.add(shape, material, place)
    }

    /// Puts a pedestal on the floor; returns the middle of its top.
    fn pedestal(&mut self, x: f64, z: f64, side: f64, height: f64) -> DVec3 {
        let middle = DVec3::new(x, FLOOR + 0.5 * height, z);
        add_block(&mut self.plaster, middle, DVec3::new(side, height, side));
        DVec3::new(x, FLOOR + height, z)
    }
}

fn matt(name: &str, diffuse: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        diffuse,
        ..Material::default()
    }
}

fn textured(name: &str, texture: Texture) -> Material {
    Material {
        texture: Some(texture),
        ..matt(name, [1.0; 3])
    }
}

fn metal(name: &str, colour: [f32; 3], roughness: f32, texture: Option<Texture>) -> Material {
    Material {
        microfacets: Some(Microfacets {
            metalness: 1.0,
            roughness,
            texture,
        }),
        ..matt(name, colour)
    }
}

fn clear(name: &str, index: f32, priority: u32, absorption: [f32; 3]) -> Material {
    Material {
        transmission: [1.0; 3],
        index_of_refraction: index,
        priority,
        absorption,
        ..matt(name, [0.0; 3])
    }
}

fn lamp(name: &str, emission: [f32; 3]) -> Material {
    Material {
        emission,
        ..matt(name, [0.0; 3])
    }
}

const fn ball(radius: f32) -> Shape {
    Shape::Sphere { radius }
}

/// Returns a room of brick, oak and plaster under a skylight, with one thing for each effect; a
/// golden animal turns in the light of a spot.
pub fn gallery() -> Scene {
    let mut room = Room::default();
    walls(&mut room);
    animal(&mut room);
    metals(&mut room);
    glass(&mut room);
    colours(&mut room);
    plant(&mut room);
    let plaster = std::mem::take(&mut room.plaster);
    room.mesh(
        plaster,
        matt("plaster", [0.68, 0.66, 0.62]),
        DAffine3::IDENTITY,
    );
    Scene {
        name: "gallery".into(),
        lights: vec![
            Light::Rectangle {
                centre: DVec3::new(4.12, 2.26, -1.9),
                right: DVec3::new(0.0, 0.0, -4.3),
                up: DVec3::new(0.0, 0.06, 0.0),
                colour: [2.6, 2.3, 1.8],
                samples: 4,
                two_sided: false,
            },
            Light::Directional {
                direction: DVec3::new(0.82, -0.5, -0.34),
                colour: [1.2, 1.02, 0.78],
            },
            Light::Spot {
                position: DVec3::new(1.9, 2.3, -1.2),
                direction: DVec3::new(-1.9, -2.5, -2.3),
                cone: [0.16, 0.24],
                colour: [14.0, 12.0, 9.0],
                inverse_square: true,
            },
        ],
        environment: Some(Environment {
            image: surfaces::sky(),
            yaw: 0.0,
            strength: 1.0,
        }),
        background: Background {
            zenith: [0.32, 0.52, 0.86],
            horizon: [0.86, 0.89, 0.92],
            nadir: [0.24, 0.20, 0.16],
            alpha: 1.0,
        },
        ambient: [0.24, 0.26, 0.29],
        ..room.scene
    }
}

/// The floor, the walls, the skylight's frame, a mirror and a railing.
fn walls(room: &mut Room) {
    let still = DAffine3::IDENTITY;
    let floor = plate(
        DVec3::new(-4.5, FLOOR, 3.0),
        DVec3::new(9.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, -9.5),
    );
    let oak = Texture::new(Pattern::Image(surfaces::parquet()), [4.5, 4.75]);
    room.mesh(floor, textured("oak", oak), still);
    let brick = Texture::new(Pattern::Image(surfaces::bricks()), [5.0, 2.5]);
    let back = plate(
        DVec3::new(-4.5, FLOOR, -6.5),
        DVec3::new(9.0, 0.0, 0.0),
        DVec3::new(0.0, 4.5, 0.0),
    );
    let joints = Texture::new(Pattern::Image(surfaces::joints()), [5.0, 2.5]);
    let brick = Material {
        normal_map: Some(NormalMap {
            texture: joints,
            scale: 1.0,
        }),
        ..textured("brick", brick)
    };
    room.mesh(back, brick, still);
    add_plate(
        &mut room.plaster,
        DVec3::new(4.5, FLOOR, -6.5),
        DVec3::new(0.0, 0.0, 9.5),
        DVec3::new(0.0, 4.5, 0.0),
    );
    // The left side is open to the garden above a parapet with a railing.
    let middle = DVec3::new(-4.4, FLOOR + 0.175, -1.75);
    add_block(&mut room.plaster, middle, DVec3::new(0.2, 0.35, 9.5));
    let iron = metal("iron", [0.12, 0.12, 0.13], 0.5, None);
    let from = DVec3::new(-4.4, FLOOR + 0.35, -6.4);
    room.mesh(rail(from, DVec3::new(0.0, 0.0, 9.2), 0.75, 46), iron, still);
    // A beam on either side of the skylight.
    for z in [-4.3, -2.1] {
        let middle = DVec3::new(0.0, 2.75, z);
        add_block(&mut room.plaster, middle, DVec3::new(9.0, 0.3, 0.3));
    }
    let silver = metal("mirror", [0.92, 0.93, 0.93], 0.0, None);
    let glass = plate(
        DVec3::new(4.42, -1.1, -5.2),
        DVec3::new(0.0, 0.0, 2.2),
        DVec3::new(0.0, 2.6, 0.0),
    );
    room.mesh(glass, silver, still);
    let gilt = metal("gilt", [0.85, 0.62, 0.25], 0.35, None);
    let mut frame = TriangleMesh::default();
    add_block(
        &mut frame,
        DVec3::new(4.47, 0.2, -4.1),
        DVec3::new(0.08, 2.8, 2.4),
    );
    room.mesh(frame, gilt, still);
    // A lamp along the wall, which shines on the wall alone.
    let shine = plate(
        DVec3::new(4.1, 2.2, -6.2),
        DVec3::new(0.0, 0.0, 8.6),
        DVec3::new(0.0, 0.12, 0.0),
    );
    let tube = lamp("tube", [1.0, 0.93, 0.8]);
    room.mesh(shine, tube, still).casts_shadow = false;
}

/// A golden animal on a turntable.
fn animal(room: &mut Room) {
    let top = room.pedestal(0.0, -3.5, 1.2, 0.7);
    let dark = matt("basalt", [0.06, 0.06, 0.065]);
    let disc = lathe(
        &[[0.0, 0.0], [0.56, 0.0], [0.56, 0.05], [0.0, 0.05]],
        48,
        false,
    );
    room.mesh(disc, dark, DAffine3::from_translation(top));
    let mesh = quadruped();
    let fitted = Normalisation::of(&mesh).map(|normal| {
        let placement = Placement {
            position: top + DVec3::new(0.0, 0.47, 0.0),
            rotation_degrees: [0.0; 3],
            scale: DVec3::splat(1.3),
        };
        placement.world_from_object(&normal)
    });
    let place = fitted.unwrap_or_default();
    let gold = metal("gold", [1.0, 0.77, 0.34], 0.12, None);
    room.mesh(mesh, gold, place);
    let object = room.scene.objects.len() - 1;
    let axis = DAffine3::from_translation(top);
    let rest = Local::Free {
        position: top,
        rotation: DQuat::from_rotation_y(0.6),
        scale: DVec3::ONE,
    };
    let clip = Clip {
        name: "turntable".into(),
        channels: vec![Channel {
            node: 0,
            course: Course::Spin {
                axis: DVec3::Y,
                seconds: TURN,
            },
        }],
        plays: true,
        ..Clip::default()
    };
    let motion = &mut room.scene.motion;
    motion.move_object(object, rest, axis.inverse() * place, clip);
}

/// Brushed, polished and rough metal.
fn metals(room: &mut Room) {
    let top = room.pedestal(-1.7, -3.7, 0.6, 0.8);
    let brushed = Texture::new(Pattern::Image(surfaces::brushed()), [2.0, 1.0]);
    let steel = metal("brushed steel", [0.66, 0.67, 0.69], 0.6, Some(brushed));
    let vase = [
        [0.0, 0.0],
        [0.16, 0.0],
        [0.2, 0.1],
        [0.24, 0.3],
        [0.2, 0.5],
        [0.1, 0.66],
        [0.08, 0.74],
        [0.13, 0.8],
        [0.11, 0.8],
        [0.0, 0.72],
    ];
    room.mesh(
        lathe(&vase, 64, true),
        steel,
        DAffine3::from_translation(top),
    );
    let place =
        |x: f64, z: f64, radius: f64| DAffine3::from_translation(DVec3::new(x, FLOOR + radius, z));
    let chrome = metal("chrome", [0.9, 0.91, 0.92], 0.0, None);
    room.add(ball(0.28), chrome, place(-0.95, -2.75, 0.28));
    let copper = metal("rough copper", [0.84, 0.36, 0.2], 0.5, None);
    room.add(ball(0.2), copper, place(-0.35, -2.45, 0.2));
}

/// A glass with water and a lemon in it, and a gem that splits light.
fn glass(room: &mut Room) {
    let top = room.pedestal(1.6, -3.3, 0.55, 0.8);
    let at = DAffine3::from_translation(top + DVec3::new(0.0, 0.002, 0.0));
    let tumbler = [
        [0.0, 0.0],
        [0.17, 0.0],
        [0.2, 0.55],
        [0.185, 0.55],
        [0.158, 0.04],
        [0.0, 0.04],
    ];
    let pane = clear("glass", 1.5, 2, [1.2, 0.4, 0.8]);
    room.mesh(lathe(&tumbler, 64, true), pane, at);
    // A little larger than the hollow: the glass has the higher priority.
    let water = [[0.0, 0.035], [0.162, 0.035], [0.181, 0.36], [0.0, 0.36]];
    let wet = clear("water", 1.333, 1, [0.9, 0.25, 0.1]);
    room.mesh(lathe(&water, 64, true), wet, at);
    let lemon = Shape::Spheroid {
        equatorial_radius: 0.07,
        polar_radius: 0.09,
    };
    let turn = DQuat::from_rotation_z(1.1);
    let inside = top + DVec3::new(0.03, 0.14, 0.02);
    let place = DAffine3::from_rotation_translation(turn, inside);
    room.add(lemon, matt("lemon", [0.92, 0.75, 0.08]), place);
    let flint = Material {
        medium: Some(Medium::SF11),
        ..clear("flint", 1.78, 3, [0.0; 3])
    };
    let gem = [[0.0, 0.0], [0.17, 0.16], [0.11, 0.22], [0.0, 0.22]];
    let place = DAffine3::from_rotation_translation(
        DQuat::from_rotation_z(0.72) * DQuat::from_rotation_y(0.2),
        DVec3::new(1.0, FLOOR + 0.13, -2.6),
    );
    room.mesh(lathe(&gem, 8, false), flint, place);
}

/// Lamps, a globe of wire, a checkered ball and a painted one.
fn colours(room: &mut Room) {
    let lantern = lamp("lantern", [1.0, 0.72, 0.36]);
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    room.add(ball(0.17), lantern.clone(), at(-2.9, 0.55, -4.0))
        .casts_shadow = false;
    room.add(ball(0.12), lantern, at(-2.4, 0.95, -4.5))
        .casts_shadow = false;
    let top = room.pedestal(2.9, -4.8, 0.6, 0.9);
    let wire = Material {
        graticule: Some(Graticule {
            divisions: 6,
            width: 0.05,
        }),
        ..matt("globe", [0.1, 0.35, 0.42])
    };
    let place = DAffine3::from_rotation_translation(
        DQuat::from_rotation_z(0.41),
        top + DVec3::new(0.0, 0.32, 0.0),
    );
    room.add(ball(0.32), wire, place);
    let checker = Texture::new(
        Pattern::Checker([[0.75, 0.1, 0.08], [0.9, 0.88, 0.82]]),
        [12.0, 6.0],
    );
    let place = at(2.2, FLOOR + 0.3, -2.9);
    room.add(ball(0.3), textured("checkered ball", checker), place);
    let painted = Material {
        vertex_colours: true,
        ..matt("painted", [1.0; 3])
    };
    let profile = [
        [0.0, 0.0],
        [0.1, 0.0],
        [0.17, 0.16],
        [0.15, 0.34],
        [0.05, 0.46],
        [0.0, 0.46],
    ];
    let mut jar = lathe(&profile, 40, true);
    let paint = |[_, y, _]: &[f32; 3]| surfaces::glaze(y / 0.46);
    jar.colours = jar.positions.iter().map(paint).collect();
    room.mesh(jar, painted, at(0.45, FLOOR, -2.35));
}

/// A plant whose leaves are cut out by the alpha of a texture.
fn plant(room: &mut Room) {
    let pot = [
        [0.0, 0.0],
        [0.2, 0.0],
        [0.28, 0.42],
        [0.25, 0.42],
        [0.23, 0.36],
        [0.0, 0.36],
    ];
    let at = DAffine3::from_translation(DVec3::new(-3.2, FLOOR, -4.6));
    let clay = matt("clay", [0.5, 0.23, 0.14]);
    room.mesh(lathe(&pot, 40, true), clay, at);
    let leaf = Texture::new(Pattern::Image(surfaces::leaf()), [1.0, 1.0]);
    let leaves = Material {
        alpha: Some(Alpha {
            opacity: 1.0,
            texture: Some(leaf.clone()),
            cover: Cover::Mask(0.5),
        }),
        ..textured("leaves", leaf)
    };
    room.mesh(branches(26), leaves, at);
}
