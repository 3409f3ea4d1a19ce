use super::super::BASE64;
use super::*;
use base64::Engine as _;

/// Numbers of points, twice, and of cells; then points, a strip and a square.
const ASCII: [&str; 8] = [
    "0 1 2 3 4",
    "1 2 3 -nan(ind) 5",
    "9 7 8",
    "0 0 0 1 0 0 1 1 0 0 1 0 2 0.5 0",
    "1 4 2",
    "3",
    "0 1 2 3",
    "4",
];
const LITTLE: &str = "byte_order='LittleEndian' header_type='UInt32'";
const LITTLE_ENDIAN: [&str; 8] = [
    "CgAAAAAAAQACAAMABAA=",
    "FAAAAAAAgD8AAABAAABAQAAAwH8AAKBA",
    "GAAAAAkAAAAAAAAABwAAAAAAAAAIAAAAAAAAAA==",
    "PAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAIA/AAAAAAAAAAAAAIA/AAAAAAAAAEAAAAA/AAAAAA==",
    "GAAAAAEAAAAAAAAABAAAAAAAAAACAAAAAAAAAA==",
    "CAAAAAMAAAAAAAAA",
    "IAAAAAAAAAAAAAAAAQAAAAAAAAACAAAAAAAAAAMAAAAAAAAA",
    "CAAAAAQAAAAAAAAA",
];
const BIG: &str = "byte_order='BigEndian' header_type='UInt64' compressor='vtkZLibDataCompressor'";
const BIG_ENDIAN_COMPRESSED: [&str; 8] = [
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAKAAAAAAAAABI=eF5jYGBgZGBiYGZgAQAAKAAL",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAUAAAAAAAAABg=eF6zb2BgcGAAYiBRfwBIL2BgAAAkWAOf",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAYAAAAAAAAABI=eF5jYAADTgjFwA6lOQAA+AAZ",
    "AAAAAAAAAAIAAAAAAAAAIAAAAAAAAAAcAAAAAAAAABEAAAAAAAAAEw==\
     eF5jYEAA+wZUNggDABaAAj54XmNggAD7BgjtAGJDxQATgAE/",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAYAAAAAAAAABI=eF5jYAADRgjFwAKlmQAATwAI",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAIAAAAAAAAAAw=eF5jYAADZgAACwAE",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAAAAAAAAAAABI=eF5jYEABjFCaCUozAwAARgAH",
    "AAAAAAAAAAEAAAAAAAAAIAAAAAAAAAAIAAAAAAAAAAw=eF5jYAADFgAADAAF",
];

/// Returns a file as VTK writes it.
fn file(head: &str, format: &str, contents: [&str; 8]) -> Vec<u8> {
    let mut text = format!(
        "<VTKFile type='PolyData' {head}><PolyData><FieldData/><Piece NumberOfPoints='5' \
         NumberOfLines='1   ' NumberOfStrips='1' NumberOfPolys='1'>"
    );
    let mut appended = Vec::new();
    let arrays = [
        ("<PointData Scalars='p'>", "id", "Int16"),
        ("", "p", "Float32"),
        ("</PointData><CellData>", "c", "Int64"),
        ("</CellData><Points>", "Points", "Float32"),
        ("</Points><Strips>", "connectivity", "Int64"),
        ("", "offsets", "Int64"),
        ("</Strips><Polys>", "connectivity", "Int64"),
        ("", "offsets", "Int64"),
    ];
    for ((part, name, number), content) in arrays.into_iter().zip(contents) {
        let (each, at) = (if name == "Points" { 3 } else { 1 }, appended.len());
        let (said, inside) = match format {
            "ascii" | "binary" => (format, content),
            _ => ("appended", ""),
        };
        let array = format!(
            "{part}<DataArray type='{number}' Name='{name}' NumberOfComponents='{each}' \
             format='{said}' offset='{at}  '><InformationKey>1</InformationKey>\n{inside}\n\
             </DataArray>"
        );
        text += &array;
        match format {
            "raw" => content.split('=').for_each(|part| {
                BASE64.decode_vec(part, &mut appended).unwrap();
            }),
            "base64" => appended.extend(content.bytes()),
            _ => {}
        }
    }
    let encoding = format!("</Polys></Piece></PolyData><AppendedData encoding='{format}'>\n _");
    let end = b"\n</AppendedData></VTKFile>";
    [text.as_bytes(), encoding.as_bytes(), &appended, end].concat()
}

/// Returns the same file in several ways.
pub(in crate::scene::import) fn files() -> Vec<Vec<u8>> {
    let mut files = vec![file("", "ascii", ASCII)];
    for format in ["binary", "base64", "raw"] {
        files.push(file(LITTLE, format, LITTLE_ENDIAN));
        files.push(file(BIG, format, BIG_ENDIAN_COMPRESSED));
    }
    files
}

fn read(bytes: &[u8]) -> Result<Model, ImportError> {
    parse(Path::new("a.vtp"), bytes)
}

#[test]
fn all_ways_give_the_same_surface_and_colours() {
    let expected = read(&files()[0]).unwrap();
    assert_eq!(expected.mesh.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(expected.mesh.positions[4], [2.0, 0.5, 0.0]);
    let scalar = expected.scalar.as_ref().unwrap().to_string();
    assert_eq!(scalar, "p from 1 (violet) to 5 (yellow)");
    let unused = ["the points' id", "the cells' c", "1 line"];
    assert_eq!(expected.unused.names(), unused);
    let (least, greatest) = (expected.mesh.colours[0], expected.mesh.colours[4]);
    assert!(least[2] > least[1] && greatest[1] > greatest[2]);
    assert_eq!(expected.mesh.colours[3], NO_NUMBER);
    let text = String::from_utf8(files().swap_remove(0)).unwrap();
    let odd = read(text.replace("1 2 3 -nan(ind)", "1 x").as_bytes()).unwrap();
    assert_eq!(odd.mesh.triangles, expected.mesh.triangles);
    assert_eq!(odd.mesh.colours, [NO_NUMBER; 5]);
    assert!(odd.unused.names()[1].contains("'x', no number"));
    for bytes in files() {
        assert_eq!(read(&bytes).unwrap(), expected);
    }
}

#[test]
fn cells_have_colours_of_their_own() {
    let text = String::from_utf8(file("", "ascii", ASCII)).unwrap();
    let text = text.replace(" Scalars='p'", "");
    let model = read(
        text.replace("<CellData", "<CellData Scalars='c'")
            .as_bytes(),
    )
    .unwrap();
    let scalar = model.scalar.unwrap().to_string();
    assert_eq!(scalar, "c from 7 (violet) to 8 (yellow)");
    let mesh = model.mesh;
    assert_eq!(mesh.positions.len(), 7);
    let of = |triangle: usize| mesh.triangles[triangle].map(|v| mesh.colours[v as usize]);
    assert_eq!(of(0), of(1));
    assert_ne!(of(0), of(2));
}

#[test]
fn tells_what_is_wrong() {
    let text = String::from_utf8(file("", "ascii", ASCII)).unwrap();
    for (old, new, says) in [
        ("PolyData' ", "ImageData' ", "ImageData, not PolyData"),
        (
            "Data' ",
            "Data' compressor='vtkLZ4' ",
            "compressed by vtkLZ4",
        ),
        ("Points='5'", "Points='6'", "'Points' has 15 of 18 numbers"),
        (
            "Points='5'",
            "Points='4000000000'",
            "more than 201326592 points",
        ),
        (
            "Strips='1'",
            "Strips='99999999999'",
            "has 1 of 99999999999 numbers",
        ),
        (
            "1 4 2",
            "1 5 2",
            "Strips names vertex 5, but the vertices go from 0 to 4",
        ),
        ("1 4 2", "1 x 2", "'x', no number"),
        ("\n3\n", "\n99999999999\n", "more than 201326592 corners"),
        ("</Polys>", "", "not a VTK XML file"),
    ] {
        let text = text.replace(old, new);
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}
