// What changes of a graph need beside the graph itself: the solid's place, files, and strokes to follow.

import type { App } from '../app';
import { fileDialog } from '../dialogs/pick';
import { presentIn, startingOperations } from '../fields';
import { Graph, wantedFile } from '../graph';
import type { Json } from '../protocol';
import { bodyJson, bodyKey, solidOf, type State } from '../store';

/** The place and the graph of the chosen body's solid; null when it is not computed. */
export function graphOf(state: State): { place: string; graph: Graph } | null {
  const solid = solidOf(state);
  return solid?.json.kind === 'procedural' ? { place: solid.place, graph: new Graph(solid.json, state.functions) } : null;
}

/** Asks for a file where nodes of a function must have one. */
export function withFile(app: App, name: string, run: (file: string | null) => void): void {
  const kind = wantedFile(app.store.state.schema, name);
  if (kind) fileDialog(app, kind, run);
  else run(null);
}

/** Does operations that bring in a function; one that follows the direction field gets strokes to follow with it. */
export async function addNodes(app: App, step: string, operations: Json[], from: string): Promise<boolean> {
  const { state } = app.store;
  try {
    const start = from !== 'direction' ? []
      : startingOperations({ depth: true, direction: true, vectors: false, scale: false }, presentIn(bodyJson(state)),
        app.model.meshes.get(state.body));
    return await app.actions.apply(step, [...start.map((each) => ({ ...each, ...bodyKey(state) })), ...operations]);
  } catch (reason) {
    app.actions.complain((reason as Error).message);
    return false;
  }
}
