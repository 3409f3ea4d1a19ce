// Measures made viewers as the page measures its visitors: each sees gaps from a size of its own on.
import path from "node:path";

const { staircases, line } = await import(path.resolve(process.argv[2], "fovea.js"));
const DEGREE = Math.PI / 180;
for (const [slope, least] of [[0.03, 0.02], [0.05, 0.05], [0.12, 0.1]]) {
  const sees = ({ angle, gap }) => gap >= least + slope * angle;
  const ask = async (one, turn) => (sees(one) ? turn : (turn + 1) % 4);
  const found = line(await staircases([4, 8, 12], 0.001, ask));
  for (const angle of [4, 8, 12]) {
    const ratio = (found.least / DEGREE + found.slope * angle) / (least + slope * angle);
    if (!(ratio > 0.75 && ratio < 1.3)) {
      throw new Error(`a viewer of ${least}° and ${slope} more a degree was found to see ${JSON.stringify(found)}`);
    }
  }
}
console.log("three made viewers: what they see was found");
