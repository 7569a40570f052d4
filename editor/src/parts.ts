// Operations on parts: the pieces that cuts leave. A point in a part names it.

import type { App } from './app';
import type { Json, Point } from './protocol';
import { bodyKey } from './store';

/** Hides or shows a part of the view. */
export function hidePart(app: App, index: number, hidden: boolean): Promise<boolean> {
  const part = app.model.parts[index];
  if (!part) return Promise.resolve(false);
  const operation = { op: hidden ? 'part.hide' : 'part.show', at: part.inside, ...bodyKey(app.store.state, part.body) };
  return app.actions.apply(hidden ? 'Hide part' : 'Show part', [operation]);
}

/** Shows all hidden parts, as one step; says so when there are none. */
export async function showAllParts(app: App): Promise<void> {
  await app.actions.settled(); // a part may just be on its way out of sight
  if (anyHidden(app.store.state.document)) await app.actions.apply('Show all parts', [{ op: 'part.show', all: true }]);
  else app.messages.say('Nothing is hidden.');
}

/** Puts parts that were moved by hand back where the cuts left them, and no longer pulls them apart for looking. */
export async function bringTogether(app: App): Promise<void> {
  app.store.set({ apart: 0 });
  if (anyMoved(app.store.state.document)) await app.actions.apply('Bring parts together', [{ op: 'part.together' }]);
}

interface PartEntry { hidden?: boolean; offset?: Point }

/** Is a part hidden? */
export function anyHidden(document: Json): boolean {
  return ((document.parts ?? []) as PartEntry[]).some((part) => part.hidden);
}

/** Has a part been moved by hand? */
export function anyMoved(document: Json): boolean {
  return ((document.parts ?? []) as PartEntry[]).some((part) => part.offset?.some((x) => x !== 0));
}

/** The gap that a cut gets which keeps both sides: a little of what the uncut model measures, so that one cut more moves
    pieces no further than the first did. */
export function gapOf(app: App, keep: string): { gap?: number } {
  return keep === 'both' ? { gap: Number((0.12 * app.model.diagonal()).toPrecision(3)) } : {};
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
