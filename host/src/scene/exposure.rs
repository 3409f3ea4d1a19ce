//! How bright a scene is shown.

use super::material::Material;
use super::mesh::TriangleMesh;
use super::texture::{Pattern, Texture};
use super::{Light, Object, Scene, Shape};
use fast_srgb8::srgb8_to_f32;
use glam::{DAffine3, DMat3, DVec3};

/// Triangles of each object that are looked at.
const MOST: usize = 4096;

impl Scene {
    /// Makes all light brighter by so many stops: doublings.
    pub fn expose(&mut self, stops: f64) {
        let factor = libm::exp2(stops);
        let brighter = |colour: &mut [f32; 3]| {
            *colour = colour.map(|channel| (f64::from(channel) * factor) as f32);
        };
        for light in &mut self.lights {
            let (Light::Point { colour, .. }
            | Light::Spot { colour, .. }
            | Light::Directional { colour, .. }
            | Light::Rectangle { colour, .. }) = light;
            brighter(colour);
        }
        if let Some(environment) = &mut self.environment {
            environment.strength = (f64::from(environment.strength) * factor) as f32;
        }
        let background = &mut self.background;
        for colour in [
            &mut self.ambient,
            &mut background.zenith,
            &mut background.horizon,
            &mut background.nadir,
        ] {
            brighter(colour);
        }
        let own = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.materials);
        for material in self.materials.iter_mut().chain(own) {
            brighter(&mut material.emission);
        }
    }

    /// Returns whether nothing gives light, and no mirror or glass shows a background.
    pub fn is_dark(&self) -> bool {
        let own = self.meshes.iter().flat_map(|mesh| &mesh.materials);
        let mut materials = self.materials.iter().chain(own);
        let background = &self.background;
        let sky = self.environment.is_some()
            || [background.zenith, background.horizon, background.nadir] != [[0.0; 3]; 3];
        let shows = |one: &Material| {
            let passes_on =
                one.microfacets.is_some() || [one.mirror, one.transmission] != [[0.0; 3]; 2];
            one.emission != [0.0; 3] || (sky && passes_on)
        };
        self.lights.is_empty() && self.ambient == [0.0; 3] && !materials.any(shows)
    }

    /// Returns the stops, a whole number of halves, that make bright surfaces of its meshes nearly
    /// white: 0 where they are already between a third of white and white, or where nothing is
    /// bright. Shadows do not count.
    pub fn suitable_exposure(&self) -> f64 {
        let objects = self.objects.iter();
        let mut lights: Vec<f64> = objects.flat_map(|object| self.brightness(object)).collect();
        lights.retain(|light| light.is_finite());
        lights.sort_by(f64::total_cmp);
        match lights.get(lights.len() * 19 / 20) {
            Some(&bright) if bright > 1.0e-9 && !(0.35..=1.0).contains(&bright) => {
                (2.0 * libm::log2(0.8 / bright)).round() / 2.0
            }
            _ => 0.0,
        }
    }

    /// Returns the luminance of some triangles of an object, seen from their bright sides.
    fn brightness(&self, object: &Object) -> Vec<f64> {
        let Shape::Mesh(number) = object.shape else {
            return Vec::new();
        };
        let mesh = &self.meshes[number];
        let looks: Vec<[[f64; 3]; 2]> = match object.material {
            Some(material) => vec![look(&self.materials[material])],
            None if mesh.materials.is_empty() => vec![look(&Material::default())],
            None => mesh.materials.iter().map(look).collect(),
        };
        let step = mesh.triangles.len().div_ceil(MOST).max(1);
        let triangles = (0..mesh.triangles.len()).step_by(step);
        let brightness = triangles.map(|triangle| {
            let own = mesh.triangle_materials.get(triangle);
            let own = own.filter(|_| object.material.is_none());
            let [diffuse, emission] = looks[own.map_or(0, |own| *own as usize)];
            let [place, normal] = surface(mesh, triangle, &object.world_from_object);
            let [front, back] = [normal, -normal].map(|normal| self.irradiance(place, normal));
            let light = if front.element_sum() > back.element_sum() {
                front
            } else {
                back
            };
            let shown = light * DVec3::from(diffuse) + DVec3::from(emission);
            shown.dot(DVec3::new(0.2126, 0.7152, 0.0722))
        });
        brightness.collect()
    }

    fn irradiance(&self, place: DVec3, normal: DVec3) -> DVec3 {
        let wide = |colour: [f32; 3]| DVec3::from(colour.map(f64::from));
        let mut sum = wide(self.ambient);
        for light in &self.lights {
            let (towards, colour) = match *light {
                Light::Directional { direction, colour } => (-direction, wide(colour)),
                Light::Point {
                    position,
                    colour,
                    inverse_square,
                }
                | Light::Spot {
                    position,
                    colour,
                    inverse_square,
                    ..
                } => {
                    let towards = position - place;
                    let squared = if inverse_square {
                        towards.length_squared()
                    } else {
                        1.0
                    };
                    (towards, wide(colour) / squared)
                }
                Light::Rectangle {
                    centre,
                    right,
                    up,
                    colour,
                    ..
                } => {
                    let towards = centre - place;
                    let area = 4.0 * right.cross(up).length();
                    let spread = std::f64::consts::PI * towards.length_squared();
                    (towards, wide(colour) * (area / spread))
                }
            };
            let cosine = towards.normalize_or_zero().dot(normal).max(0.0);
            sum += colour * cosine;
        }
        sum
    }
}

/// Returns the middle of a triangle and its normal, in the world.
fn surface(mesh: &TriangleMesh, triangle: usize, place: &DAffine3) -> [DVec3; 2] {
    let [a, b, c] = mesh.triangles[triangle].map(|corner| {
        let position = mesh.positions[corner as usize];
        place.transform_point3(DVec3::from(position.map(f64::from)))
    });
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
    [DMat3::from_cols(a, b, c) * DVec3::splat(1.0 / 3.0), normal]
}

/// Returns the diffuse reflectance and the emission of a material, with the means of its textures.
fn look(material: &Material) -> [[f64; 3]; 2] {
    [
        (material.diffuse, &material.texture),
        (material.emission, &material.emission_texture),
    ]
    .map(|(colour, texture)| {
        let mean = texture.as_ref().map_or([1.0; 3], mean);
        [0, 1, 2].map(|channel| f64::from(colour[channel]) * mean[channel])
    })
}

fn mean(texture: &Texture) -> [f64; 3] {
    let (sum, count) = match &texture.pattern {
        Pattern::Checker(colours) => {
            let sum = [0, 1, 2].map(|channel| {
                let both = colours.map(|colour| f64::from(colour[channel]));
                both[0] + both[1]
            });
            (sum, 2.0)
        }
        Pattern::Image(image) => {
            let step = image.texels().len().div_ceil(MOST).max(1);
            let texels = image.texels().iter().step_by(step);
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for &[r, g, b, _] in texels {
                for (sum, code) in sum.iter_mut().zip([r, g, b]) {
                    *sum += f64::from(srgb8_to_f32(code));
                }
                count += 1.0;
            }
            (sum, count)
        }
    };
    sum.map(|sum| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a white square under a light that falls straight down.
    fn lit(colour: f32) -> Scene {
        let mut scene = Scene::of_meshes(vec![TriangleMesh::square()]);
        scene.ambient = [0.0; 3];
        scene.lights = vec![Light::Directional {
            direction: DVec3::NEG_Y,
            colour: [colour; 3],
        }];
        scene
    }

    #[test]
    fn exposure_makes_what_is_bright_nearly_white_and_leaves_what_is() {
        // Its reflectance is 0.8.
        for (light, stops) in [
            (1.0, 0.0),
            (0.5, 0.0),
            (0.25, 2.0),
            (64.0, -6.0),
            (0.0, 0.0),
        ] {
            let mut scene = lit(light);
            assert_eq!(scene.suitable_exposure(), stops, "{light}");
            scene.expose(stops);
            assert_eq!(scene.suitable_exposure(), 0.0, "{light}");
        }
        // A lamp that shines, in the dark, and a photograph.
        let mut lamp = lit(0.0);
        lamp.meshes[0].materials = vec![Material {
            emission: [8.0; 3],
            ..Material::default()
        }];
        lamp.meshes[0].triangle_materials = vec![0; 2];
        assert_eq!(lamp.suitable_exposure(), -3.5);
        let before = lamp.background;
        lamp.expose(-3.0);
        assert_eq!(lamp.meshes[0].materials[0].emission, [1.0; 3]);
        assert_eq!(lamp.background.zenith, before.zenith.map(|c| c / 8.0));
    }
}
