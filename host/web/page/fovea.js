// A visitor's own acuity: how large the screen is, how far away, and how small a gap is seen beside
// the line of sight.

const CARD = [0.0856, 0.05398]; // A bank card's sides, metres (ISO/IEC 7810 ID-1).
const NARROW = 500; // Pixels across, in which a card has no room but upright.
const TRIALS = 10; // Of each eccentricity.
const SHOWN = 350; // Milliseconds: too short to look there.
const DEGREE = Math.PI / 180;
const TURNS = { ArrowRight: 0, ArrowDown: 1, ArrowLeft: 2, ArrowUp: 3 };

/// Asks, measures, and returns {pixelsAMetre, distance, slope, least, seen}; null where it is given up.
export function measureFovea(dialog) {
  const $ = (name) => dialog.querySelector(`[name=${name}]`);
  const canvas = dialog.querySelector("canvas");
  const pages = [...dialog.querySelectorAll("section")];
  const turn = (number) => pages.forEach((page, at) => { page.hidden = at !== number; });
  let pixelsAMetre = 96 / 0.0254;
  const isUpright = innerWidth < NARROW;
  const [across, down] = isUpright ? [...CARD].reverse() : CARD;
  $("upright").hidden = !isUpright;
  $("distance").value = isUpright ? 30 : 55;
  const size = () => {
    pixelsAMetre = Number($("card").value) / across;
    Object.assign($("box").style, { width: `${across * pixelsAMetre}px`, height: `${down * pixelsAMetre}px` });
  };
  $("card").oninput = size;
  turn(0);
  dialog.showModal();
  // A box that does not fit would be narrower than it says.
  $("card").max = Math.min(700, pages[0].clientWidth);
  size();
  return new Promise((resolve) => {
    let answer = null;
    const end = (found) => {
      removeEventListener("keydown", key, true);
      dialog.onclose = null;
      dialog.close();
      resolve(found);
    };
    const key = (event) => {
      if (answer && event.key in TURNS) {
        event.preventDefault();
        event.stopPropagation();
        answer(TURNS[event.key]);
      }
    };
    addEventListener("keydown", key, true);
    dialog.onclose = () => end(null);
    dialog.querySelectorAll("[data-turn]").forEach((button) => {
      button.onclick = () => answer?.(Number(button.dataset.turn));
    });
    $("next").onclick = () => turn(1);
    $("begin").onclick = async () => {
      turn(2);
      const distance = Number($("distance").value) / 100;
      const scale = pixelsAMetre * distance;
      Object.assign(canvas, { width: canvas.clientWidth, height: canvas.clientHeight });
      const fits = (angle) => scale * Math.tan(angle * DEGREE) < canvas.width - 60;
      const angles = [4, 8, 12, 16].filter(fits).slice(-3);
      if (angles.length < 2 || !(distance >= 0.15 && distance <= 2)) return end({});
      const ask = async (one, turn) => {
        await show(canvas, scale, one, turn);
        return new Promise((done) => { answer = (turn) => { answer = null; done(turn); }; });
      };
      const seen = await staircases(angles, 1 / scale / DEGREE, ask);
      end({ pixelsAMetre, distance, seen, ...line(seen) });
    };
  });
}

/// Measures the gap that is seen at some eccentricities, degrees: [eccentricity, gap]. No gap is below
/// `smallest`. `ask` shows a ring of {angle, gap} with its gap at a turn from 0 to 3, and returns which
/// turn was seen.
export async function staircases(angles, smallest, ask) {
  const all = angles.map((angle) => ({ angle, gap: 2 * (0.02 + 0.03 * angle), right: 0, turns: [], last: 0 }));
  for (let trial = 0; trial < TRIALS * all.length; trial += 1) {
    const one = all[trial % all.length];
    const turn = Math.floor(4 * Math.random());
    const isRight = (await ask(one, turn)) === turn;
    // Two right ones make it smaller, a wrong one larger: it ends where 71 % are right.
    one.right = isRight ? one.right + 1 : 0;
    const step = isRight ? (one.right % 2 === 0 ? -1 : 0) : 1;
    if (step !== 0 && one.last !== 0 && step !== one.last) one.turns.push(one.gap);
    if (step !== 0) one.last = step;
    one.gap = Math.max(one.gap * 1.3 ** step, smallest);
  }
  return all.map(({ angle, gap, turns }) => {
    const last = turns.length > 0 ? turns.slice(-4) : [gap];
    const mean = Math.exp(last.reduce((sum, one) => sum + Math.log(one), 0) / last.length);
    return [angle, mean];
  });
}

/// Shows a ring with a gap beside a cross, for a moment.
async function show(canvas, scale, { angle, gap }, turn) {
  const context = canvas.getContext("2d");
  const [x, y] = [24, canvas.height / 2];
  const clear = () => {
    context.fillStyle = "#fff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = "#000";
    context.fillRect(x - 8, y - 1, 17, 3);
    context.fillRect(x - 1, y - 8, 3, 17);
  };
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  clear();
  await wait(500);
  // Landolt's ring: the gap and the stroke are a fifth of its width.
  const stroke = scale * Math.tan(gap * DEGREE);
  context.save();
  context.translate(x + scale * Math.tan(angle * DEGREE), y);
  context.rotate(turn * Math.PI / 2);
  context.lineWidth = stroke;
  const half = Math.asin(0.25);
  context.beginPath();
  context.arc(0, 0, 2 * stroke, half, 2 * Math.PI - half);
  context.stroke();
  context.restore();
  await wait(SHOWN);
  clear();
}

/// Fits the least angle that is seen, radians, by the eccentricity: slope and, on the line of sight,
/// least.
export function line(seen) {
  const [n, sx, sy, sxx, sxy] = seen.reduce(
    ([n, sx, sy, sxx, sxy], [x, y]) => [n + 1, sx + x, sy + y, sxx + x * x, sxy + x * y], [0, 0, 0, 0, 0]);
  const spread = n * sxx - sx * sx;
  const slope = spread > 0 ? (n * sxy - sx * sy) / spread : sy / Math.max(sx, 1e-9);
  const bound = (number, low, high) => Math.min(high, Math.max(low, number));
  const steep = bound(slope, 0.002, 1);
  return { slope: steep, least: bound((sy - steep * sx) / Math.max(n, 1), 0.005, 1) * DEGREE };
}
