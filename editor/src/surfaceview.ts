// The surfaces that colours flow from, in the view: when they are shown, which, and what can be done to one.

import type { App } from './app';
import type { Json } from './protocol';
import { boundsBody, chosenSurface, surfaceKey, surfacesOf, type State } from './store';

/** Keeps the view of surfaces in step with what is chosen. */
export function installSurfaceView(app: App): void {
  const { store, viewport } = app;
  const refresh = (): void => {
    const { state } = store, { body, mode, tool, paintWhat } = state;
    viewport.lookWithin(mode === 'surfaces' ? state.skin : null);
    viewport.surfaces.look(body, state.shownSurfaces, state.selectedSurface, tool === 'paint-surface' && paintWhat === 'blur',
      (surface) => boundsBody(state, surface.body, surface.name));
    viewport.invalidate();
  };
  viewport.surfaces.onChange = refresh;
  store.on(['mode', 'skin', 'body', 'document', 'shownSurfaces', 'selectedSurface', 'tool', 'paintWhat'], refresh);
  // A surface that is gone is not chosen any more, and without any there is nothing to look at.
  store.on(['document', 'body'], () => {
    const { state } = store;
    if (state.selectedSurface !== null && !chosenSurface(state)) store.set({ selectedSurface: null });
    if (state.mode === 'surfaces' && state.bodies.every((_, i) => surfacesOf(state, i).length === 0)) store.set({ mode: 'solid' });
  });
  store.on(['surfacesWhy'], () => {
    if (store.state.surfacesWhy) app.messages.say(store.state.surfacesWhy, 'warning');
  });
  refresh();
}

/** Shows or hides a surface of the body that tools work on. */
export function showSurface({ store }: App, name: string, on: boolean): void {
  const { [name]: _, ...others } = store.state.shownSurfaces;
  store.set({ shownSurfaces: on ? others : { ...others, [name]: false } });
}

/** Has a surface a colour for each side? */
export function isTwoSided(surface: Json): boolean {
  return surface.colours?.back !== undefined || ((surface.paint ?? []) as Json[]).some((paint) => paint.back !== undefined);
}

/** Why the chosen surface's sides cannot exchange their colours; null when they can. */
export function flipObstacle(state: State): string | null {
  const chosen = chosenSurface(state);
  if (!chosen) return 'Choose a surface first.';
  return isTwoSided(chosen.json) ? null : 'This surface has one colour for both sides; paint one of them first.';
}

/** Exchanges the colours of the chosen surface's front and back. */
export function flipSurface(app: App): Promise<boolean> {
  const { state } = app.store;
  return app.actions.apply('Flip surface',
    [{ op: 'surface.flip', surface: state.selectedSurface, ...surfaceKey(state) }]);
}

/** Operations that give a surface a colour for each side, as it looks now; none where it has them. */
export function twoSidedOperations(surface: Json, place: string): Json[] {
  if (isTwoSided(surface)) return [];
  const front = surface.colours?.front ?? '#ffffff';
  return [{ op: 'set', path: `${place}.colours.back`, value: front },
    ...((surface.paint ?? []) as Json[]).flatMap((paint, i) =>
      (paint.front === undefined ? [] : [{ op: 'set', path: `${place}.paint[${i}].back`, value: paint.front }]))];
}
