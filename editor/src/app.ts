// What everything of the page holds on to, and the two verbs it changes the document with.

import type { Actions } from './actions';
import type { Connection } from './connection';
import type { Model } from './model';
import type { Json, Point } from './protocol';
import { bodyKey, type Store } from './store';
import type { Messages } from './ui/dialog';

/** Where the eye is, as a document's camera says it. */
export interface Pose { eye: Point; target: Point; up: Point; field_of_view: number }

/** What panels and commands ask of the view. */
export interface Viewer {
  pose(): Pose;
  look(pose: Pose): void;
  /** Shows everything, or the picked part. */
  frame(): void;
  /** Looks from a direction, at a fitted distance. */
  from(direction: Point, up: Point): void;
}

export interface App {
  store: Store;
  connection: Connection;
  actions: Actions;
  model: Model;
  viewer: Viewer;
  messages: Messages;
}

/** Sets a value of the document, as a step called `name`. */
export function setValue(app: App, name: string, path: string, value: unknown): Promise<boolean> {
  return app.actions.apply(name, [{ op: 'set', path, value }]);
}

/** Takes a value of the document away, as a step called `name`. */
export function removeValue(app: App, name: string, path: string): Promise<boolean> {
  return app.actions.apply(name, [{ op: 'remove', path }]);
}

/** Does operations of the chosen body, as a step called `name`; the body's name is added to each. */
export function operate(app: App, name: string, ...operations: Json[]): Promise<boolean> {
  const body = bodyKey(app.store.state);
  return app.actions.apply(name, operations.map((operation) => ({ ...operation, ...body })));
}
