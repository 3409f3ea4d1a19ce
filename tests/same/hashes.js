// The hashes of described frames by the page's program, in node and in a browser.

/// Words of a description before its pictures, and of each picture.
const BEFORE = 21;
const PICTURE = 27;

/// What a description has: the bits of its effects, the sizes of its pictures, and how many objects
/// it moves and tiles it cuts off.
export function described(bytes) {
  const word = (at) => new DataView(bytes.buffer, bytes.byteOffset).getUint32(4 * at, true);
  const pictures = Array.from({ length: word(BEFORE - 1) }, (_, number) => {
    const at = BEFORE + PICTURE * number + 13;
    return { size: [word(at), word(at + 1)] };
  });
  const end = BEFORE + PICTURE * pictures.length;
  const moved = word(end);
  return { effects: word(3), pictures, moved, cuts: word(end + 1 + 25 * moved) };
}

/// `FRAME PICTURE HASH` of each picture of descriptions, a line each.
export async function hashes({ Core, tiles }, program, scene, frames) {
  const core = await Core.open(await WebAssembly.compile(program), scene);
  return frames.flatMap((frame, number) => {
    const { pictures } = described(frame);
    core.begin(frame);
    const all = tiles(pictures).map((tile) => {
      core.render(tile);
      return core.hash();
    });
    return core.wallHashes(pictures, all).map(({ hash }, picture) =>
      `${number} ${picture} ${hash.toString(16).padStart(16, "0")}`);
  });
}
