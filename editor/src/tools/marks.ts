// The document's strokes and points over the view, while one works on the fields they make.

import { Vector3 } from 'three';
import type { App } from '../app';
import type { Json, Point } from '../protocol';
import { bodyJson } from '../store';
import { write } from '../ui/numbers';
import { paletteCss } from '../view/looks';
import type { Mark } from '../view/overlay';

const vectors = (points: Point[]): Vector3[] => points.map((point) => new Vector3(...point));

/* Seen over every depth's colour and every texture. */
const bright = '#ff5fd2';

/** Keeps the marks in step with the document. */
export function installMarks(app: App): void {
  const { store, viewport } = app;
  const refresh = (): void => {
    const { tab, inspector, tool, pointed } = store.state;
    const fields = (inspector && tab === 'fields') || ['fill', 'face', 'depth', 'points', 'direction', 'scale'].includes(tool);
    const pastes = tool === 'paste' || (pointed?.startsWith('paste') ?? false);
    viewport.overlay.show('document', fields || pastes ? marksOf(bodyJson(store.state), fields, pastes, pointed) : null);
  };
  store.on(['document', 'body', 'tab', 'tool', 'inspector', 'serial', 'pointed'], refresh);
  refresh();
}

/** What a body's fields, or its pastes, look like as marks; the one that is pointed at stands out. */
export function marksOf(body: Json, fields: boolean, pastes: boolean, pointed: string | null): Mark[] {
  const marks: Mark[] = [];
  const stroke = (name: string, points: Point[], colour: string, width: number, arrow: boolean): void => {
    const on = name === pointed;
    marks.push({ points: vectors(points), colour: on ? bright : colour, width: on ? width + 2.5 : width, arrow });
  };
  const dots = (name: string, points: Point[], colour: string, size: number, label?: string): void => {
    const on = name === pointed;
    marks.push({ points: vectors(points), colour: on ? bright : colour, dots: on ? size + 2.5 : size, label });
  };
  if (fields) {
    ((body.depth?.constraints ?? []) as Json[]).forEach(({ stroke: line, points, depth }, i) => {
      if (line) stroke(`depth ${i}`, line, paletteCss(depth), 3.5, false);
      if (points) dots(`depth ${i}`, points, paletteCss(depth), 5);
    });
    const lists = { direction: body.direction?.strokes, 'vectors.surface': body.vectors?.surface, 'vectors.inside': body.vectors?.inside };
    for (const [name, strokes] of Object.entries(lists)) {
      ((strokes ?? []) as Point[][]).forEach((points, i) => stroke(`${name} ${i}`, points, '#ffffff', 2, true));
    }
    ((body.scale?.points ?? []) as Json[]).forEach(({ point, size }, i) => dots(`scale ${i}`, [point], '#ffffff', 4, write(Number(size.toPrecision(3)))));
  }
  const solid = (body.solids as Json[] | undefined)?.find((each) => each.name === body.solid) ?? body.solids?.[0];
  if (pastes) ((solid?.pastes ?? []) as Json[]).forEach((paste, i) => dots(`paste ${i}`, [paste.point], '#ffffff', 4));
  return marks;
}
