//! Contenders out of shared libraries.

use super::report::Row;
use libloading::Library;
use shisen::bake::{BakeError, Baked, lone_mesh};
use shisen::scene::mesh::TriangleMesh;
use shisen_peers_interface::{Contender as Raw, Hit, List, Mesh, Rays, SYMBOL, Task};
use std::ffi::{CStr, c_char, c_void};
use std::fmt::Write as _;
use std::path::Path;
use std::ptr::NonNull;

pub struct Contender {
    pub name: String,
    pub mode: String,
    pub version: String,
    pub simd: String,
    pub task: Task,
    raw: &'static Raw,
}

pub struct Subject {
    pub name: String,
    pub mesh: TriangleMesh,
    pub baked: Baked<8>,
    corners: Vec<f32>,
}

pub struct RaySet {
    pub name: &'static str,
    /// Origin and direction.
    pub rays: Vec<[f32; 6]>,
    /// Pixels a row of a picture; 0 for other rays.
    pub side: usize,
}

pub struct Opened<'s> {
    raw: &'static Raw,
    tree: NonNull<c_void>,
    _mesh: Box<Mesh>,
    _subject: &'s Subject,
}

fn text(from: *const c_char) -> String {
    // SAFETY: the interface promises text that ends in 0 and never changes.
    let text = unsafe { CStr::from_ptr(from) };
    text.to_string_lossy().into_owned()
}

/// Returns the version of a package in the lock file; empty where it is not there.
pub fn locked(package: &str) -> String {
    let lock = include_str!("../Cargo.lock");
    let start = format!("name = \"{package}\"\nversion = \"");
    let found = lock
        .split_once(&start)
        .and_then(|(_, rest)| rest.split_once('"'));
    found.map_or(String::new(), |(version, _)| version.to_owned())
}

impl Contender {
    /// Loads all contenders of a library, which stays loaded.
    pub fn load(path: &Path) -> Result<Vec<Self>, libloading::Error> {
        // SAFETY: built by `run` from the sources beside this; nothing runs on loading.
        let library = Box::leak(Box::new(unsafe { Library::new(path) }?));
        // SAFETY: that is its type in all of them.
        let list = unsafe { library.get::<List>(SYMBOL) }?;
        let mut count = 0;
        // SAFETY: it writes the count, and the contenders stay where they are.
        let all = unsafe { std::slice::from_raw_parts(list(&raw mut count), count) };
        Ok(all.iter().map(Self::new).collect())
    }

    fn new(raw: &'static Raw) -> Self {
        let name = text(raw.name);
        let version = match text(raw.version) {
            version if version.is_empty() && name == "Shisen" => locked("shisen-core"),
            version if version.is_empty() => locked(&name),
            version => version,
        };
        Self {
            name,
            mode: text(raw.mode),
            version,
            simd: text(raw.simd),
            task: raw.task,
            raw,
        }
    }

    pub fn is_ours(&self) -> bool {
        self.name == "Shisen"
    }

    /// Returns whether it is ours as `cargo build --release` builds it.
    pub fn is_default(&self) -> bool {
        self.is_ours() && self.mode.starts_with("default")
    }

    /// Returns a row about it without a number.
    pub fn row(&self, part: &'static str, subject: &str, what: &str) -> Row {
        Row {
            subject: subject.to_owned(),
            what: what.to_owned(),
            peer: self.name.clone(),
            mode: self.mode.clone(),
            version: self.version.clone(),
            simd: self.simd.clone(),
            ..Row::of_part(part)
        }
    }

    /// Builds its tree; `None` if it cannot.
    pub fn open<'s>(&self, subject: &'s Subject) -> Option<Opened<'s>> {
        let mesh = Box::new(Mesh {
            corners: subject.corners.as_ptr(),
            triangles: subject.mesh.triangles.len(),
            baked: subject.baked.as_bytes().as_ptr(),
            baked_bytes: subject.baked.as_bytes().len(),
        });
        // SAFETY: what it points to outlives what is opened.
        let tree = NonNull::new(unsafe { (self.raw.open)(&raw const *mesh) })?;
        Some(Opened {
            raw: self.raw,
            tree,
            _mesh: mesh,
            _subject: subject,
        })
    }
}

impl Opened<'_> {
    pub fn trace(&self, rays: &RaySet, hits: &mut [Hit]) {
        assert_eq!(rays.rays.len(), hits.len(), "a hit for each ray");
        let rays = Rays {
            rays: rays.rays.as_ptr(),
            count: rays.rays.len(),
            side: rays.side,
        };
        // SAFETY: the sizes agree.
        unsafe { (self.raw.trace)(self.tree.as_ptr(), &raw const rays, hits.as_mut_ptr()) };
    }
}

impl Drop for Opened<'_> {
    fn drop(&mut self) {
        // SAFETY: of `open`, and not used any more.
        unsafe { (self.raw.close)(self.tree.as_ptr()) };
    }
}

impl Subject {
    pub fn new(name: impl Into<String>, mesh: TriangleMesh) -> Result<Self, BakeError> {
        let corners = mesh.triangles.iter().flatten();
        let corners = corners
            .flat_map(|&corner| mesh.positions[corner as usize])
            .collect();
        Ok(Self {
            name: name.into(),
            baked: Baked::new(&lone_mesh(mesh.clone()))?,
            mesh,
            corners,
        })
    }

    /// Writes the triangles as OBJ, digit for digit.
    pub fn write_obj(&self, path: &Path) -> std::io::Result<()> {
        let mut text = String::new();
        for [x, y, z] in &self.mesh.positions {
            // Writing to a string does not fail.
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for triangle in &self.mesh.triangles {
            let [a, b, c] = triangle.map(|corner| corner + 1);
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        std::fs::write(path, text)
    }
}
