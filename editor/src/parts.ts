// Operations on parts: the pieces that cuts leave. A point in a part names it.

import { type App } from './app';
import type { Point } from './protocol';

/** Hides or shows a part of the view. */
export function hidePart(app: App, index: number, hidden: boolean): Promise<boolean> {
  const part = app.model.parts[index];
  if (!part) return Promise.resolve(false);
  return app.actions.apply(hidden ? 'Hide part' : 'Show part', [partOperation(part.inside, hidden)]);
}

/** Shows all hidden parts, as one step. */
export function showAllParts(app: App): Promise<boolean> {
  const hidden = app.model.parts.filter((part) => part.hidden);
  if (hidden.length === 0) return Promise.resolve(false);
  return app.actions.apply('Show all parts', hidden.map((part) => partOperation(part.inside, false)));
}

function partOperation(at: Point, hidden: boolean): { [key: string]: unknown } { return { op: 'part.hide', at, hidden }; }

/** Puts parts that were moved by hand back where the cuts left them, and no longer pulls them apart for looking. */
export async function bringTogether(app: App): Promise<void> {
  app.store.set({ apart: 0 });
  const moved = (app.store.state.document.parts ?? []).filter((part: { offset?: Point }) => part.offset?.some((x) => x !== 0));
  if (moved.length === 0) return;
  await app.actions.apply('Bring parts together',
    moved.map((part: { at: Point }) => ({ op: 'part.move', at: part.at, offset: [0, 0, 0] })));
}

/** Parts as people tell them apart: the body's name where there are several, and a number within the body. */
export function partNames(app: App): string[] {
  const { bodies } = app.store.state, counts = new Map<number, number>(), all = new Map<number, number>();
  for (const part of app.model.parts) all.set(part.body, (all.get(part.body) ?? 0) + 1);
  return app.model.parts.map((part) => {
    const nth = (counts.get(part.body) ?? 0) + 1, name = bodies.length > 1 ? bodies[part.body]?.name ?? 'Body' : 'Part';
    counts.set(part.body, nth);
    return (all.get(part.body) ?? 0) > 1 || bodies.length <= 1 ? `${name} ${nth}` : name;
  });
}
