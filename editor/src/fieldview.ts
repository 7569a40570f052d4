// Fields to look at: asks for the layer and the streamlines that the store names, one request at a time, and again when
// the model changed.

import type { App } from './app';
import { Refusal } from './connection';
import type { Packet } from './protocol';
import { bodyJson, type State } from './store';

/** Keeps the view's layer and streamlines in step with the store. */
export function installFieldView(app: App): void {
  const { store, viewport } = app;
  const layer = latest(app, () => layerRequest(store.state), async (keys) => {
    viewport.showLayer(keys && await app.connection.ask<Packet>('layer', keys), store.state.body);
  });
  const lines = latest(app, () => linesRequest(store.state), async (keys) => {
    viewport.showLines(keys ? [await app.connection.ask<Packet>('lines', keys)] : []);
  });
  store.on(['layer', 'body', 'serial', 'connection'], layer);
  store.on(['lines', 'linesOf', 'layer', 'body', 'serial', 'connection'], lines);
  viewport.element.addEventListener('wheel', (event) => {
    if (!event.altKey || !bodyJson(store.state).depth) return;
    event.preventDefault();
    event.stopPropagation();
    store.set({ layer: stepLayer(store.state.layer, 0.02 * Math.sign(event.deltaY)) });
  }, { capture: true, passive: false });
}

/** The layer a step further in (above 0) or out; the first step shows one in the middle. */
export function stepLayer(layer: number | null, step: number): number {
  return layer === null ? 0.5 : Math.round(100 * Math.min(1, Math.max(0, layer + step))) / 100;
}

function bodyName(state: State): { body?: string } {
  return state.document.bodies ? { body: state.document.bodies[state.body]?.name } : {};
}

function layerRequest(state: State): { [key: string]: unknown } | null {
  if (state.layer === null || state.connection !== 'open' || !bodyJson(state).depth) return null;
  // Nothing has depth 0 or 1 but the constraints themselves: the ends of the range are looked at a little inside.
  return { ...bodyName(state), depth: Math.min(0.995, Math.max(0.005, state.layer)) };
}

function linesRequest(state: State): { [key: string]: unknown } | null {
  if (state.lines === 'none' || state.connection !== 'open') return null;
  return {
    ...bodyName(state), where: state.lines, ...(state.linesOf ? { of: state.linesOf } : {}),
    ...(state.lines === 'layer' ? { depth: Math.min(0.995, Math.max(0.005, state.layer ?? 0.5)) } : {}),
  };
}

/* Does what a request says; while one is under way only the last of those that come is done afterwards. What was done
   already is not done again, unless the model is another one. */
function latest<T>(app: App, read: () => T | null, act: (keys: T | null) => Promise<void>): () => void {
  let busy = false, again = false, shown = 'null';
  const run = async (): Promise<void> => {
    const keys = read(), text = keys ? JSON.stringify([keys, app.store.state.serial]) : 'null';
    if (text === shown) return;
    if (busy) { again = true; return; }
    busy = true;
    try {
      await act(keys);
      shown = text;
    } catch (reason) {
      shown = text;
      if (!(reason instanceof Refusal && reason.status === 'superseded')) app.actions.complain(
        (reason as Error).message);
    }
    busy = false;
    if (again) { again = false; void run(); }
  };
  return () => void run();
}
