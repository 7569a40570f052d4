// What a pane shows: grid, picture, axis, folds, curves.

import type { Json, Point } from '../protocol';
import { write } from '../ui/numbers';
import { chosenSurface, surfacesOf } from '../store';
import { isPositive, type Vec } from './curve';
import { colourOf, foldsOf, type Curve } from './drawn';
import type { Pane } from './pane';

export const axisColour = '#3fae5a';
const halo = 'rgba(0, 0, 0, 0.55)';

/** The page's colours, as its theme has them. */
export function themeColour(name: string): string { return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`); }

/** Draws everything below what tools show. */
export function drawPane(brush: CanvasRenderingContext2D, pane: Pane): void {
  brush.lineJoin = brush.lineCap = 'round';
  drawPicture(brush, pane);
  const numbers = drawGrid(brush, pane);
  drawAxis(brush, pane);
  const { selectedSurface } = pane.app.store.state, { curves } = pane;
  if (pane.name === 'vertical') for (const curve of curves) drawMirror(brush, pane, curve);
  for (const curve of curves) if (curve.surface !== selectedSurface) drawCurve(brush, pane, curve, false);
  for (const curve of curves) if (curve.surface === selectedSurface) drawCurve(brush, pane, curve, true);
  drawRegion(brush, pane);
  drawNumbers(brush, numbers);
}

/* Where the chosen grains are strewn. */
function drawRegion(brush: CanvasRenderingContext2D, pane: Pane): void {
  const grains = chosenSurface(pane.app.store.state)?.json;
  if (pane.name !== 'vertical' || grains?.kind !== 'grains') return;
  brush.globalAlpha = 0.35;
  for (const { points, radius = 0 } of (grains.region ?? []) as Json[]) {
    const at = (points as Point[]).map(([x, y, z]) => pane.toScreen(Math.hypot(x, y), z));
    line(brush, at.length > 1 ? at : [at[0], at[0]], colourOf(grains), Math.max(3, 2 * radius * pane.zoom));
  }
  brush.globalAlpha = 1;
}

/* ---- below the curves ---------------------------------------------------------------------------------------------- */

function drawPicture(brush: CanvasRenderingContext2D, pane: Pane): void {
  const picture = pane.session.pictures[pane.name], { place, image } = picture;
  if (!place || !image) return;
  brush.save();
  brush.globalAlpha = pane.session.opacity(pane.name);
  brush.translate(...pane.toScreen(place.x, place.y));
  brush.rotate((-place.turn * Math.PI) / 180);
  brush.scale(pane.zoom, pane.zoom);
  brush.imageSmoothingQuality = 'high';
  brush.drawImage(image, -place.width / 2, -place.tall / 2, place.width, place.tall);
  brush.restore();
}

interface Numbers { text: string; x: number; y: number; align: CanvasTextAlign }

/* The step of the grid: 1, 2 or 5 times a power of ten, some 64 pixels wide. */
export function gridStep(zoom: number): number {
  const wide = 64 / zoom, power = 10 ** Math.floor(Math.log10(wide));
  return power * ([1, 2, 5].find((times) => times * power >= wide) ?? 10);
}

function drawGrid(brush: CanvasRenderingContext2D, pane: Pane): Numbers[] {
  const step = gridStep(pane.zoom), [left, top] = pane.toModel(0, 0), [right, bottom] = pane.toModel(pane.width, pane.height);
  const numbers: Numbers[] = [], round = (value: number): number => Number((Math.round(value / step) * step).toPrecision(10));
  brush.beginPath();
  for (let i = Math.ceil(left / step); i * step <= right; ++i) {
    const [x] = pane.toScreen(i * step, 0), value = pane.name === 'vertical' ? Math.abs(i * step) : i * step;
    brush.moveTo(x, 0);
    brush.lineTo(x, pane.height);
    if (x > 40 && x < pane.width - 8) numbers.push({ text: write(round(value)), x, y: pane.height - 5, align: 'center' });
  }
  for (let i = Math.ceil(bottom / step); i * step <= top; ++i) {
    const [, y] = pane.toScreen(0, i * step);
    brush.moveTo(0, y);
    brush.lineTo(pane.width, y);
    if (y > 40 && y < pane.height - 22) numbers.push({ text: write(round(i * step)), x: 5, y: y - 4, align: 'left' });
  }
  brush.strokeStyle = themeColour('pane-grid');
  brush.lineWidth = 1;
  brush.stroke();
  return numbers;
}

function drawNumbers(brush: CanvasRenderingContext2D, numbers: Numbers[]): void {
  brush.font = '11px system-ui, sans-serif';
  brush.lineWidth = 3;
  brush.strokeStyle = themeColour('pane');
  brush.fillStyle = themeColour('quiet');
  for (const { text, x, y, align } of numbers) {
    brush.textAlign = align;
    brush.strokeText(text, x, y);
    brush.fillText(text, x, y);
  }
}

/** Where the handle lies that turns the folds; null without folds, and along the axis. */
export function foldHandle(pane: Pane): Vec | null {
  const { count, angle } = foldsOf(pane.app.store.state), turn = ((pane.session.heldAngle ?? angle) * Math.PI) / 180;
  if (pane.name !== 'horizontal' || count < 1) return null;
  const [x, y] = pane.toScreen(0, 0), far = Math.max(70, 0.42 * Math.min(pane.width, pane.height));
  return [x + far * Math.cos(turn), y - far * Math.sin(turn)];
}

function drawAxis(brush: CanvasRenderingContext2D, pane: Pane): void {
  const [x, y] = pane.toScreen(0, 0);
  if (pane.name === 'vertical') {
    brush.fillStyle = themeColour('pane-shade');   // what cannot be drawn on
    brush.fillRect(0, 0, Math.max(0, x), pane.height);
    return line(brush, [[x, 0], [x, pane.height]], axisColour, 2);
  }
  const { count, angle } = foldsOf(pane.app.store.state), first = pane.session.heldAngle ?? angle;
  const far = 2 * (pane.width + pane.height) + Math.hypot(x, y);
  for (let i = 0; i < count; ++i) {
    const turn = ((first + (360 * i) / count) * Math.PI) / 180;
    brush.setLineDash(i === 0 ? [] : [5, 5]);
    line(brush, [[x, y], [x + far * Math.cos(turn), y - far * Math.sin(turn)]], axisColour, i === 0 ? 1.5 : 1);
  }
  brush.setLineDash([]);
  const handle = foldHandle(pane);
  if (handle) dot(brush, handle, 6, axisColour, '#ffffff');
  dot(brush, [x, y], 4, axisColour, '#ffffff');
}

/* ---- curves -------------------------------------------------------------------------------------------------------- */

function drawMirror(brush: CanvasRenderingContext2D, pane: Pane, curve: Curve): void {
  brush.globalAlpha = 0.35;
  line(brush, curve.spline.line.map(([x, y]) => pane.toScreen(-x, y)), curve.colour, 1.5);
  brush.globalAlpha = 1;
}

function drawCurve(brush: CanvasRenderingContext2D, pane: Pane, curve: Curve, chosen: boolean): void {
  const width = chosen ? 3 : 2, surface = surfacesOf(pane.app.store.state)[curve.at];
  brush.globalAlpha = curve.implied ? 0.6 : 1;
  if (curve.implied) brush.setLineDash([6, 5]);
  for (const { points, gone } of stretches(curve, surface)) {
    const at = points.map(([x, y]) => pane.toScreen(x, y));
    if (gone) {
      brush.setLineDash([2, 5]);
      brush.globalAlpha = 0.5;
      line(brush, at, curve.colour, 1.5);
      brush.globalAlpha = curve.implied ? 0.6 : 1;
      brush.setLineDash(curve.implied ? [6, 5] : []);
    } else {
      line(brush, at, halo, width + 2.5);
      line(brush, at, curve.colour, width);
    }
  }
  brush.setLineDash([]);
  brush.globalAlpha = 1;
  const { tool } = pane.session.values;
  if (chosen && (tool === 'edit' || tool === 'bend' || tool === 'smooth')) drawKnots(brush, pane, curve);
}

/* The curve in stretches that are there, and those that an erasing stroke of the same pane has taken away. */
function stretches(curve: Curve, surface: Json | undefined): { points: Vec[]; gone: boolean }[] {
  const erased = ((surface?.erase ?? []) as Json[]).filter((each) => each[curve.pane]);
  const { line: points } = curve.spline;
  if (erased.length === 0) return [{ points, gone: false }];
  const gone = ([x, y]: Vec): boolean => erased.some((each) =>
    isPositive(each[curve.pane], each.closed === true, x, y) === ((each.side ?? 'positive') === 'positive'));
  const found: { points: Vec[]; gone: boolean }[] = [];
  points.forEach((point) => {
    const now = gone(point), last = found[found.length - 1];
    if (last?.gone === now) last.points.push(point);
    else {
      last?.points.push(point);
      found.push({ points: [point], gone: now });
    }
  });
  return found;
}

function drawKnots(brush: CanvasRenderingContext2D, pane: Pane, curve: Curve): void {
  const { knot } = pane.session.values;
  curve.knots.forEach(({ x, y, corner }, i) => {
    const [px, py] = pane.toScreen(x, y), chosen = knot?.curve === curve.key && knot.index === i;
    const fill = chosen ? themeColour('accent') : '#ffffff', size = chosen ? 5.5 : 4;
    if (!corner) return dot(brush, [px, py], size, fill, '#202020');
    brush.fillStyle = fill;
    brush.strokeStyle = '#202020';
    brush.lineWidth = 1.5;
    brush.beginPath();
    brush.rect(px - size, py - size, 2 * size, 2 * size);
    brush.fill();
    brush.stroke();
  });
}

/* ---- strokes and dots ---------------------------------------------------------------------------------------------- */

export function line(brush: CanvasRenderingContext2D, points: readonly Vec[], colour: string, width: number): void {
  brush.beginPath();
  points.forEach(([x, y], i) => (i ? brush.lineTo(x, y) : brush.moveTo(x, y)));
  brush.strokeStyle = colour;
  brush.lineWidth = width;
  brush.stroke();
}

/** A line that is seen on anything. */
export function clearLine(brush: CanvasRenderingContext2D, points: readonly Vec[], colour: string, width: number): void {
  line(brush, points, halo, width + 2.5);
  line(brush, points, colour, width);
}

export function dot(brush: CanvasRenderingContext2D, [x, y]: Vec, radius: number, colour: string, edge: string): void {
  brush.beginPath();
  brush.arc(x, y, radius, 0, 2 * Math.PI);
  brush.fillStyle = colour;
  brush.fill();
  brush.strokeStyle = edge;
  brush.lineWidth = 1.5;
  brush.stroke();
}
