// Where the walls are on the stage, and which way a place of it is: as a net, around the viewer, or one
// screen of their own. `state` says what is chosen: {scene, view, screen, head}.
import { WALLS, vectors } from "./frame.js";

const { plus, minus, times, dot, cross, unit } = vectors;

/// Where the eye is in the room: in the middle, or where a record has it.
export const eyeOf = ({ head }) => head ?? [0, 0, 0];

/// Where each wall of the net is, and its part of the stage's width.
const CELLS = [[0, 0], [1, 0], [0, 1]];
export const wallsOf = ({ screen }) => (screen ? [screen] : WALLS);
const share = ({ screen }) => (screen ? 1 : 0.5);

/// Puts the pictures of the walls into a stage of some pixels.
export function placeWalls(state, room, canvases, width) {
  const isDome = state.scene?.dome;
  const isViewer = state.view === "viewer" && !isDome && !state.screen;
  room.className = isViewer ? "viewer" : "";
  const half = width / 2;
  if (isDome) {
    Object.assign(canvases[0].style, { left: 0, top: 0, width: `${width}px`, transform: "" });
    return;
  }
  if (!isViewer) {
    const side = share(state) * width;
    canvases.forEach((canvas, wall) => Object.assign(canvas.style, {
      left: `${CELLS[wall][0] * side}px`, top: `${CELLS[wall][1] * side}px`,
      width: `${side}px`, height: `${side}px`, transform: "",
    }));
    return;
  }
  // A cube of 1000 pixels around the viewer, who is as far from the screen as its perspective.
  const side = 1000, distance = half;
  const [yaw, pitch] = angles(camera());
  const turned = `translateZ(${distance}px) rotateX(${-pitch}rad) rotateY(${yaw}rad)`;
  const faces = ["", "rotateY(-90deg)", "rotateX(90deg)"];
  room.style.perspective = `${distance}px`;
  canvases.forEach((canvas, wall) => Object.assign(canvas.style, {
    left: `${half - side / 2}px`, top: `${half - side / 2}px`, width: `${side}px`, height: `${side}px`,
    transform: `${turned} ${faces[wall]} translateZ(${-side / 2}px)`,
  }));
}

export const angles = ([x, y, z]) => [Math.atan2(x, -z), Math.asin(Math.max(-1, Math.min(1, y)))];

/// Where the viewer's head looks: towards the corner of the three walls.
const camera = () => unit([0.55, -0.45, -1]);

/// The axes of the head: right, up, forward.
function head() {
  const forward = camera();
  const right = unit(cross(forward, [0, 1, 0]));
  return [right, cross(right, forward), forward];
}

/// The direction from the eye to what is at a place of the stage; null off the walls.
export function directionAt(state, width, [x, y]) {
  const half = width / 2;
  if (state.scene?.dome) {
    const [u, v] = [x / half - 1, 1 - y / half];
    const radius = Math.hypot(u, v);
    if (radius > 1) return null;
    const angle = radius * Math.PI / 2;
    const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
    return radius === 0 ? [0, 1, 0] : [sin * u / radius, cos, sin * v / radius];
  }
  if (state.view === "viewer" && !state.screen) {
    const [right, up, forward] = head();
    return unit(plus(plus(times(right, x - half), times(up, half - y)), times(forward, half)));
  }
  const side = share(state) * width;
  const [column, row] = [Math.floor(x / side), Math.floor(y / side)];
  const wall = CELLS.findIndex(([atX, atY]) => atX === column && atY === row);
  if (!wallsOf(state)[wall]) return null;
  const { lowerLeft, lowerRight, upperLeft } = wallsOf(state)[wall];
  const across = times(minus(lowerRight, lowerLeft), x / side - column);
  const down = times(minus(lowerLeft, upperLeft), y / side - row);
  return unit(minus(plus(plus(upperLeft, across), down), eyeOf(state)));
}

/// Where a direction is on the stage; null where it is not.
export function placeOf(state, width, forward) {
  const half = width / 2;
  if (state.scene?.dome) {
    const [x, y, z] = forward;
    const angle = Math.acos(Math.max(-1, Math.min(1, y)));
    const level = Math.hypot(x, z) || 1;
    const radius = angle / (Math.PI / 2);
    return radius > 1 ? null : [half * (1 + radius * x / level), half * (1 - radius * z / level)];
  }
  if (state.view === "viewer" && !state.screen) {
    const [right, up, ahead] = head();
    const along = dot(forward, ahead);
    if (along <= 0.01) return null;
    return [half + half * dot(forward, right) / along, half - half * dot(forward, up) / along];
  }
  const side = share(state) * width;
  for (const [number, { lowerLeft, lowerRight, upperLeft }] of wallsOf(state).entries()) {
    const [column, row] = CELLS[number];
    const [across, down] = [minus(lowerRight, lowerLeft), minus(lowerLeft, upperLeft)];
    const normal = cross(across, down);
    const distance = dot(minus(upperLeft, eyeOf(state)), normal) / dot(forward, normal);
    if (!(distance > 0)) continue;
    const at = minus(plus(eyeOf(state), times(forward, distance)), upperLeft);
    const [s, t] = [dot(at, across) / dot(across, across), dot(at, down) / dot(down, down)];
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return [side * (column + s), side * (row + t)];
  }
  return null;
}
