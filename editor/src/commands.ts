// Everything that a word or a key does, in one table: buttons, menus, the keyboard and the list of shortcuts read it.

import { Vector3 } from 'three';
import type { App } from './app';
import { stepLayer } from './fieldview';
import { bodyJson, surfacesOf, type ViewMode } from './store';
import { save, saveAs } from './dialogs/saving';
import { flipObstacle, flipSurface, showSurface } from './surfaceview';
import { anyHidden, hidePart, showAllParts } from './parts';

export interface Command {
  id: string;
  label: string;
  group: 'Document' | 'Build' | 'View' | 'Parts and cuts' | 'Page';
  keys: string[];                   // "Ctrl+Shift+Z"; the first is shown
  /** Why it cannot be done at the moment; null when it can. */
  why?: () => string | null;
  /** It is tried all the same: what the page knows may lag behind what was done, and the server says no by itself. */
  insists?: boolean;
  run: () => void;
}

/** What commands need of the page beside the app. */
export interface PageVerbs {
  focusOptions(): void;
  showShortcuts(): void;
  showHints(): void;
  chooseType(): void;
  snapshot(): void;
  theme(): void;
}

export class Commands {
  readonly all: Command[];

  constructor(private readonly app: App, verbs: PageVerbs) {
    this.all = [...this.ofDocument(), ...this.ofBuilding(verbs), ...this.ofView(verbs), ...this.ofParts(),
      ...this.ofPage(verbs)];
  }

  /** The command of this id. */
  get(id: string): Command {
    const found = this.all.find((command) => command.id === id);
    if (!found) throw new Error(`there is no command ${id}`);
    return found;
  }

  /** Does a command, unless there is a reason not to; that is said. */
  run(id: string): void {
    const command = this.get(id), why = command.why?.() ?? null;
    if (why && !command.insists) this.app.messages.say(why);
    else command.run();
  }

  private ofDocument(): Command[] {
    const { store, actions } = this.app, { state } = store;
    return [
      { id: 'undo', label: 'Undo', group: 'Document', keys: ['Ctrl+Z'], insists: true,
        why: () => (state.undo.length ? null : 'There is nothing to undo.'),
        run: () => void actions.undo() },
      { id: 'redo', label: 'Redo', group: 'Document', keys: ['Ctrl+Shift+Z', 'Ctrl+Y'], insists: true,
        why: () => (state.redo.length ? null : 'There is nothing to redo.'), run: () => void actions.redo() },
      { id: 'save', label: 'Save', group: 'Document', keys: ['Ctrl+S'], run: () => void save(this.app) },
      { id: 'save-as', label: 'Save as…', group: 'Document', keys: ['Ctrl+Shift+S'],
        run: () => saveAs(this.app) },
      { id: 'revert', label: 'Go back to the saved document', group: 'Document', keys: [],
        why: () => (state.saved ? 'The document is as it was saved.' : null), run: () => void actions.revert() },
    ];
  }

  private ofBuilding(verbs: PageVerbs): Command[] {
    const { store, actions } = this.app, { state } = store;
    const job = () => state.jobs.find((each) => each.state === 'running' || each.state === 'waiting');
    return [
      { id: 'update', label: 'Update', group: 'Build', keys: ['U'], why: () => updateObstacle(this.app),
        run: () => void actions.update('solid') },
      { id: 'automatic', label: 'Update after every change', group: 'Build', keys: [],
        run: () => void actions.automatic(!state.automatic) },
      { id: 'cancel', label: 'Stop what is being made', group: 'Build', keys: [],
        why: () => (job() ? null : 'Nothing is being made.'), run: () => void actions.cancel(job()!.job) },
      { id: 'type', label: 'Choose the texture type…', group: 'Build', keys: ['Y'], run: verbs.chooseType },
    ];
  }

  private ofView(verbs: PageVerbs): Command[] {
    const { store, viewport } = this.app, { state } = store;
    const from = (id: string, label: string, keys: string[], direction: number[]): Command => ({
      id: `from-${id}`, label, group: 'View', keys,
      run: () => viewport.table.lookFrom(new Vector3(...direction), new Vector3(0, 0, 1)),
    });
    const modes = (): ViewMode[] => ['solid', 'depth', 'shape', 'volume', ...(surfacesOf(state).length ? ['surfaces' as const] : [])];
    return [
      { id: 'frame', label: 'Show everything', group: 'View', keys: ['F'], run: () => viewport.table.frame() },
      { id: 'camera', label: 'Look as the document does', group: 'View', keys: ['0'],
        run: () => viewport.table.fromDocument(state.document.camera) },
      from('front', 'From the front', ['1'], [0, -1, 0]), from('back', 'From behind', ['Shift+1'], [0, 1, 0]),
      from('right', 'From the right', ['3'], [1, 0, 0]), from('left', 'From the left', ['Shift+3'], [-1, 0, 0]),
      from('top', 'From above', ['7'], [0, 0, 1]), from('bottom', 'From below', ['Shift+7'], [0, 0, -1]),
      { id: 'mode', label: 'Next view mode', group: 'View', keys: ['Z'],
        run: () => store.set({ mode: modes()[(modes().indexOf(state.mode) + 1) % modes().length] }) },
      { id: 'layer-up', label: 'A layer further out', group: 'View', keys: [']'], why: () => noDepth(this.app),
        run: () => store.set({ layer: stepLayer(state.layer, -0.05) }) },
      { id: 'layer-down', label: 'A layer further in', group: 'View', keys: ['['], why: () => noDepth(this.app),
        run: () => store.set({ layer: stepLayer(state.layer, 0.05) }) },
      { id: 'layer-off', label: 'No layer', group: 'View', keys: ['\\'], run: () => store.set({ layer: null }) },
      { id: 'isolines', label: 'Lines of equal depth', group: 'View', keys: ['I'],
        run: () => store.set({ isolines: !state.isolines }) },
      { id: 'lines', label: 'Streamlines', group: 'View', keys: ['L'],
        run: () => store.set({ lines: state.lines === 'none' ? (state.layer === null ? 'body' : 'layer') : 'none' }) },
      { id: 'surface-eye', label: 'Show or hide the chosen surface', group: 'View', keys: ['E'],
        why: () => (state.selectedSurface === null ? 'Choose a surface first.' : null),
        run: () => showSurface(this.app, state.selectedSurface!, state.shownSurfaces[state.selectedSurface!] === false) },
      { id: 'surface-flip', label: 'Exchange the colours of the chosen surface’s sides', group: 'View', keys: [],
        why: () => flipObstacle(state), run: () => void flipSurface(this.app) },
      { id: 'snapshot', label: 'Take a picture', group: 'View', keys: ['Shift+P'], run: verbs.snapshot },
    ];
  }

  private ofParts(): Command[] {
    const { app } = this, { store } = app, { state } = store;
    const picked = () => (state.part === null ? 'Pick a part first, with the select tool.'
      : app.model.parts[state.part]?.hidden ? 'This part is hidden already.' : null);
    return [
      { id: 'hide', label: 'Hide the picked part', group: 'Parts and cuts', keys: ['H'], why: picked,
        run: () => { void hidePart(app, state.part!, true); store.set({ part: null }); } },
      { id: 'show-all', label: 'Show all parts', group: 'Parts and cuts', keys: ['Alt+H'], insists: true,
        why: () => (anyHidden(state.document) ? null : 'Nothing is hidden.'),
        run: () => void showAllParts(app) },
      { id: 'delete', label: 'Remove the chosen cut, or hide the picked part', group: 'Parts and cuts',
        keys: ['Delete', 'Backspace'],
        why: () => (state.chosenCut !== null ? null : picked()), run: () => this.remove() },
    ];
  }

  private remove(): void {
    const { store, actions } = this.app, { chosenCut } = store.state;
    if (chosenCut === null) return this.run('hide');
    void actions.apply('Remove cut', [{ op: 'cut.remove', index: chosenCut }]);
    store.set({ chosenCut: null });
  }

  private ofPage(verbs: PageVerbs): Command[] {
    const { store, toolbox } = this.app;
    return [
      { id: 'options', label: 'Go to the tool’s options', group: 'Page', keys: ['Space'], run: verbs.focusOptions },
      { id: 'inspector', label: 'Inspector', group: 'Page', keys: ['N'],
        run: () => store.set({ inspector: !store.state.inspector }) },
      { id: 'sketch', label: 'Sketch', group: 'Page', keys: ['K'], run: () => store.set({ sketching: !store.state.sketching }) },
      { id: 'theme', label: 'Light or dark', group: 'Page', keys: [], run: verbs.theme },
      { id: 'escape', label: 'Give up what is under way, or the tool', group: 'Page', keys: ['Escape'], run: () => {
        const { busy } = toolbox;
        toolbox.cancel();
        if (!busy) store.set({ tool: 'select', chosenCut: null, part: null });
      } },
      { id: 'shortcuts', label: 'Keyboard shortcuts', group: 'Page', keys: ['?'], run: verbs.showShortcuts },
      { id: 'hints', label: 'First steps', group: 'Page', keys: [], run: verbs.showHints },
    ];
  }
}

/** Why an update would do nothing; null when it would do something. */
export function updateObstacle(app: App): string | null {
  const { bodies } = app.store.state;
  if (bodies.length === 0) return 'There is nothing to build yet.';
  const open = bodies.filter((body) => !body.why);
  if (open.length === 0) return bodies[0].why;
  return open.every((body) => body.shown && body.built.solid) ? 'What is shown is up to date.' : null;
}

function noDepth(app: App): string | null {
  return bodyJson(app.store.state).depth ? null : 'This body has no depth field.';
}
