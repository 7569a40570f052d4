// The document's strokes and points over the view, while one works on the fields they make.

import { Vector3 } from 'three';
import type { App } from '../app';
import type { Json, Point } from '../protocol';
import { bodyJson } from '../store';
import { write } from '../ui/numbers';
import { paletteCss } from '../view/looks';
import type { Mark } from '../view/overlay';

const vectors = (points: Point[]): Vector3[] => points.map((point) => new Vector3(...point));

/** Keeps the marks in step with the document. */
export function installMarks(app: App): void {
  const { store, viewport } = app;
  const refresh = (): void => {
    const { tab, inspector, tool } = store.state;
    const fields = (inspector && tab === 'fields') || ['fill', 'face', 'depth', 'points', 'direction', 'scale'].includes(tool);
    viewport.overlay.show('document', fields || tool === 'paste' ? marksOf(bodyJson(store.state), fields, tool === 'paste') : null);
  };
  store.on(['document', 'body', 'tab', 'tool', 'inspector', 'serial'], refresh);
  refresh();
}

/** What a body's fields, or its pastes, look like as marks. */
export function marksOf(body: Json, fields: boolean, pastes: boolean): Mark[] {
  const marks: Mark[] = [];
  if (fields) {
    for (const { stroke, points, depth } of (body.depth?.constraints ?? []) as Json[]) {
      const colour = paletteCss(depth);
      if (stroke) marks.push({ points: vectors(stroke), colour, width: 3.5 });
      if (points) marks.push({ points: vectors(points), colour, dots: 5 });
    }
    const strokes = [...(body.direction?.strokes ?? []), ...(body.vectors?.surface ?? []), ...(body.vectors?.inside ?? [])] as Point[][];
    for (const stroke of strokes) marks.push({ points: vectors(stroke), colour: '#ffffff', width: 2, arrow: true });
    for (const { point, size } of (body.scale?.points ?? []) as Json[]) {
      marks.push({ points: vectors([point]), colour: '#ffffff', dots: 4, label: write(Number(size.toPrecision(3))) });
    }
  }
  const solid = (body.solids as Json[] | undefined)?.find((each) => each.name === body.solid) ?? body.solids?.[0];
  if (pastes) for (const paste of (solid?.pastes ?? []) as Json[]) marks.push({ points: vectors([paste.point]), colour: '#ffffff', dots: 4 });
  return marks;
}
