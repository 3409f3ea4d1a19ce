//! `shisen inspect`: what is in a scene.

use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source::{self, Loaded, NotUsed, Source, Told};
use crate::cli::arguments::{ModelArguments, SceneName};
use crate::cli::explain::Animation;
use crate::cli::prelude::*;
use crate::files::begins_with;
use crate::scene::material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::Pattern;
use shisen_core::scene::Scene;
use shisen_core::scene::format::{
    Header, IdLeaf, Instance, LeafBlock, Light, MAGIC, Material, Mesh, Node, Table, Texel, Texture,
    Triangle,
};
use shisen_core::spectrum::Medium;
use zerocopy::FromBytes;

/// Shows what is in a scene, and checks it
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// File that `shisen bake` wrote; or a model, a TOML description or a built-in scene, which is
    /// not baked
    scene: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The contents of a baked scene.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// File of the scene.
    path: String,
    /// fast or compact.
    layout: &'static str,
    /// Version of the format.
    version: u32,
    /// Size of the scene.
    bytes: u64,
    /// Tables of the format.
    tables: Vec<TableReport>,
    /// Objects in the scene.
    instances: u32,
    /// Materials.
    materials: u32,
    /// Lights.
    lights: u32,
    /// Triangles of all meshes at their finest levels.
    triangles: usize,
    /// Polygon levels of the meshes.
    levels: Vec<Level>,
    /// Most stack entries that a ray can need.
    stack_entries: u32,
    /// Bytes of the whole scene by its triangles; null without triangles.
    bytes_per_triangle: Option<f64>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct TableReport {
    /// What is in the table.
    name: &'static str,
    /// Number of records.
    records: u32,
    /// Size of all records.
    bytes: u64,
}

/// The contents of a model, or of a scene that a TOML file describes or that is built in.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Contents {
    /// File of the model or scene, or name of a built-in scene.
    path: String,
    /// Placed shapes; 1 for a model.
    objects: usize,
    /// Lights of its own.
    lights: usize,
    /// Names of a model's cameras, for --camera.
    cameras: Vec<String>,
    /// Animations of scene files and glTF files.
    animations: Vec<Animation>,
    /// Meshes; one for a model.
    meshes: Vec<MeshContents>,
    /// Materials that the scene itself describes.
    materials: Vec<MaterialContents>,
    /// The quantity that a model's colours show, or null.
    scalar: Option<ScalarContents>,
    /// What the files have that is not shown.
    not_used: Vec<NotUsed>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct MeshContents {
    /// Triangles.
    triangles: usize,
    /// Vertices.
    vertices: usize,
    /// Least x, y and z of its vertices, in the file's unit.
    least: [f32; 3],
    /// Greatest x, y and z.
    greatest: [f32; 3],
    /// Materials of its own.
    materials: Vec<MaterialContents>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct MaterialContents {
    /// Name, which may be empty.
    name: String,
    /// Width and height of the images on it, in texels.
    images: Vec<[u32; 2]>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct ScalarContents {
    /// Name in the file.
    name: String,
    /// Least number, which is violet, in the file's unit.
    least: f32,
    /// Greatest number, which is yellow.
    greatest: f32,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = &arguments.scene;
    let named_as_baked = file.extension().is_some_and(|name| name == "shisen");
    if !named_as_baked && !begins_with(file, &MAGIC) {
        return print(&Contents::read(file)?, arguments.json);
    }
    let baked = source::load_baked(&arguments.scene)?;
    let path = arguments.scene.display().to_string();
    let report = with_scene!(baked.scene(), |scene| Report::new(path, &baked, &scene));
    print(&report, arguments.json)
}

impl Contents {
    fn read(file: &Path) -> Result<Self, Failure> {
        let mut contents = Self {
            path: file.display().to_string(),
            objects: 1,
            lights: 0,
            cameras: Vec::new(),
            animations: Vec::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
            scalar: None,
            not_used: Vec::new(),
        };
        if source::is_model(file) {
            let mut told = Told::default();
            let model = source::load_model(file, &mut told)?;
            contents.not_used = told.not_used;
            contents.cameras = model.cameras.into_iter().map(|one| one.name).collect();
            contents.lights = model.lights.len();
            contents.animations = Animation::of(&model.rig.clips);
            contents.meshes.push(MeshContents::of(&model.mesh));
            contents.scalar = model.scalar.map(|scalar| ScalarContents {
                name: scalar.name,
                least: scalar.least,
                greatest: scalar.greatest,
            });
            return Ok(contents);
        }
        let name = SceneName::from(file.as_os_str().to_owned());
        let source = Source::load(&name, &ModelArguments::default())?;
        if let Loaded::Described(scene) = source.scene {
            contents.objects = scene.objects.len();
            contents.lights = scene.lights.len();
            contents.animations = Animation::of(scene.motion.clips());
            contents.meshes = scene.meshes.iter().map(MeshContents::of).collect();
            contents.materials = scene.materials.iter().map(MaterialContents::of).collect();
        }
        contents.not_used = source.shown.told.not_used;
        Ok(contents)
    }
}

impl MeshContents {
    fn of(mesh: &TriangleMesh) -> Self {
        let (least, greatest) = mesh.bounds();
        Self {
            triangles: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            least,
            greatest,
            materials: mesh.materials.iter().map(MaterialContents::of).collect(),
        }
    }
}

impl MaterialContents {
    fn of(material: &material::Material) -> Self {
        let images = material
            .textures()
            .filter_map(|texture| match &texture.pattern {
                Pattern::Image(image) => Some([image.width(), image.height()]),
                Pattern::Checker(_) => None,
            });
        Self {
            name: material.name.clone(),
            images: images.collect(),
        }
    }
}

impl fmt::Display for Contents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [objects, lights] = [(self.objects, "object"), (self.lights, "light")]
            .map(|(count, noun)| counted(count as u64, noun));
        write!(f, "{}: {objects}, {lights}", self.path)?;
        for camera in &self.cameras {
            write!(f, "\ncamera {camera}")?;
        }
        for animation in &self.animations {
            write!(f, "\nanimation {animation}")?;
        }
        for mesh in &self.meshes {
            let ([a, b, c], [d, e, g]) = (mesh.least, mesh.greatest);
            let (triangles, vertices) = (mesh.triangles, mesh.vertices);
            write!(f, "\nmesh of {triangles} triangles, {vertices} vertices, ")?;
            write!(f, "from ({a}, {b}, {c}) to ({d}, {e}, {g}) in its unit")?;
        }
        let own = self.meshes.iter().flat_map(|mesh| &mesh.materials);
        for material in own.chain(&self.materials) {
            write!(f, "\nmaterial '{}'", material.name)?;
            for [width, height] in &material.images {
                write!(f, ", image of {width} × {height} texels")?;
            }
        }
        Ok(())
    }
}

impl Report {
    fn new<const W: usize>(path: String, baked: &BakedScene, scene: &Scene<'_, W>) -> Self {
        let tables = tables::<W>(baked.as_bytes());
        let levels = Level::of(baked);
        let triangles = Level::finest_faces(&levels);
        let length = u64::from(scene.byte_len());
        Self {
            path,
            layout: baked.layout().name(),
            version: shisen_core::scene::format::VERSION,
            bytes: length,
            tables,
            instances: scene.instances().len() as u32,
            materials: scene.materials().len() as u32,
            lights: scene.lights().len() as u32,
            triangles,
            levels,
            stack_entries: scene.stack_entries(),
            bytes_per_triangle: (triangles > 0).then(|| length as f64 / triangles as f64),
        }
    }
}

/// Returns the tables in the order of the header; empty if the bytes have no header.
fn tables<const W: usize>(bytes: &[u8]) -> Vec<TableReport> {
    let Ok((header, _)) = Header::read_from_prefix(bytes) else {
        return Vec::new();
    };
    let table = |name, table: Table, record_bytes: usize| TableReport {
        name,
        records: table.count,
        bytes: u64::from(table.count) * record_bytes as u64,
    };
    // A scene has one of two kinds of leaves.
    let leaves = if W == 8 {
        table("leaves", header.leaves, size_of::<LeafBlock<W>>())
    } else {
        table("leaves", header.id_leaves, size_of::<IdLeaf>())
    };
    vec![
        table("nodes", header.nodes, size_of::<Node<W>>()),
        leaves,
        table("meshes", header.meshes, size_of::<Mesh>()),
        table("instances", header.instances, size_of::<Instance>()),
        table("materials", header.materials, size_of::<Material>()),
        table("lights", header.lights, size_of::<Light>()),
        table("triangles", header.triangles, size_of::<Triangle>()),
        table("normals", header.normals, size_of::<[f32; 3]>()),
        table("positions", header.positions, size_of::<[f32; 3]>()),
        table("coordinates", header.coordinates, size_of::<[f32; 2]>()),
        table("textures", header.textures, size_of::<Texture>()),
        table("media", header.media, size_of::<Medium>()),
        table("colours", header.colours, size_of::<[f32; 3]>()),
        table("tangents", header.tangents, size_of::<[f32; 4]>()),
        table("texels", header.texels, size_of::<Texel>()),
    ]
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, layout, version, bytes) = (&self.path, self.layout, self.version, self.bytes);
        write!(f, "{path}: {layout} layout, format version {version}, ")?;
        writeln!(f, "{bytes} bytes")?;
        for table in &self.tables {
            let (name, records, bytes) = (table.name, table.records, table.bytes);
            writeln!(f, "{name:>12} {records:>10} records {bytes:>12} bytes")?;
        }
        let ladders = Level::by_mesh(&self.levels).filter(|levels| levels.len() > 1);
        for levels in ladders {
            writeln!(f, "polygon levels of mesh {}:", levels[0].mesh)?;
            for level in levels {
                writeln!(f, "{level}")?;
            }
        }
        if let Some(each) = self.bytes_per_triangle {
            writeln!(f, "{each:.1} bytes a triangle, with all tables")?;
        }
        write!(f, "traversal stack: at most {} entries", self.stack_entries)
    }
}
