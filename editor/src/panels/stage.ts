// The middle of the page: the view, and what lies over it.

import { takeDroppedFiles } from '../dialogs/files';
import { FirstSteps } from '../dialogs/shortcuts';
import { button } from '../ui/controls';
import { h, live, set, type Child } from '../ui/dom';
import { icon } from '../ui/icons';
import { write } from '../ui/numbers';
import { paletteCss } from '../view/looks';
import { typeOperations } from '../dialogs/type';
import { bodyJson, solidOf, type State } from '../store';
import { commandButton, type Context } from './context';
import { isBusy } from './inside';
import { toolOptions } from './tooloptions';

/** Builds the middle; gives the first steps back, which a command shows again. */
export function stage(context: Context): { element: HTMLElement; steps: FirstSteps } {
  const { app } = context, steps = new FirstSteps();
  const element = h('main', { class: 'stage', 'aria-label': 'Model' }, app.viewport.element,
    h('div', { class: 'stage-top' },
      banner(context, 'of-connection', ['connection'], ({ connection }) => connectionWords[connection]),
      banner(context, 'of-view', ['viewWhy'], ({ viewWhy }) => viewWhy && `What is shown is not what the document says. ${viewWhy}`),
      toolOptions(context)), depthScale(context), middle(context),
    h('div', { class: 'stage-low' }, steps.element, app.messages.element));
  takeDroppedFiles(app);
  return { element, steps };
}

const kept = 'What you did so far is kept beside the document.';
const connectionWords: { [state in State['connection']]: string | null } = {
  connecting: null, open: null,
  lost: `The connection to pith is lost; it is being looked for. ${kept}`,
  gone: `“pith edit” is not running; start it again, and open the address that it prints. ${kept}`,
  refused: 'This page belongs to an earlier run of pith. Open the address that “pith edit” printed last.',
};

/* Words across the view, for as long as there are any. */
function banner({ app }: Context, look: string, keys: (keyof State)[], read: (state: State) => string | null):
  HTMLElement {
  const text = h('span'), made = h('div', { class: `banner ${look}`, role: 'alert' }, icon('warning', 18), text);
  const refresh = (): void => {
    const words = read(app.store.state);
    made.hidden = words === null;
    text.textContent = words;
  };
  app.store.on(keys, refresh);
  refresh();
  return made;
}

/* The colours of depth, and the layer looked at as a handle beside them. */
function depthScale({ app }: Context): HTMLElement {
  const { store } = app;
  const ticks = [0, 0.25, 0.5, 0.75, 1];
  const bar = h('span', { class: 'scale-bar',
    style: `background: linear-gradient(to bottom, ${[...Array(17).keys()].map((i) => paletteCss(i / 16)).join(
    ', ')})` });
  const handle = h('span', { class: 'scale-handle', 'aria-hidden': 'true' });
  const track = h('div', { class: 'scale-track', role: 'slider', tabindex: 0, 'aria-label': 'Layer of depth',
    'aria-orientation': 'vertical',
    'aria-valuemin': 0, 'aria-valuemax': 1, 'data-tip': 'Drag to look at the layer of a depth; double-click for none' },
      bar,
  ticks.map((tick) => h('span', { class: 'scale-tick', style: `top: ${100 * tick}%`, 'aria-hidden': 'true' },
    write(tick))), handle);
  const scale = [h('span', { class: 'scale-end' }, 'outside'), track, h('span', { class: 'scale-end' }, 'core')];
  const none = h('span', { class: 'scale-end' }, 'This body has no depth.');
  const made = h('div', { class: 'depth-scale' }, scale, none);
  const put = (event: PointerEvent): void => {
    const box = bar.getBoundingClientRect(), at = Math.min(1, Math.max(0, (event.clientY - box.top) / box.height));
    store.set({ layer: Math.round(100 * at) / 100 });
  };
  track.addEventListener('pointerdown', (event) => { track.setPointerCapture(event.pointerId); put(event); });
  track.addEventListener('pointermove', (event) => { if (track.hasPointerCapture(event.pointerId)) put(event); });
  track.addEventListener('dblclick', () => store.set({ layer: null }));
  track.addEventListener('keydown', (event) => {
    const step = { ArrowDown: 0.05, ArrowUp: -0.05, ArrowRight: 0.05, ArrowLeft: -0.05 }[event.key];
    if (event.key === 'Delete' || event.key === 'Escape') store.set({ layer: null });
    else if (step) store.set({ layer: Math.round(100 * Math.min(1,
      Math.max(0, (store.state.layer ?? 0.5) + step))) / 100 });
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  const refresh = (): void => {
    const { mode, layer, tool } = store.state, depth = Boolean(bodyJson(store.state).depth);
    made.hidden = mode !== 'depth' && !(depth && (layer !== null
      || ['fill', 'face', 'depth', 'points', 'direction'].includes(tool)));
    none.hidden = depth;
    for (const each of scale) each.hidden = !depth;
    handle.hidden = layer === null;
    handle.style.top = `${100 * (layer ?? 0)}%`;
    handle.textContent = layer === null ? '' : write(layer);
    set(track, 'aria-valuenow', layer);
    set(track, 'aria-valuetext', layer === null ? 'no layer' : `depth ${write(layer)}`);
  };
  store.on(['mode', 'layer', 'tool', 'document', 'body'], refresh);
  refresh();
  return made;
}

/* One sentence in the middle while there is nothing to see, and the button that changes it. */
function middle(context: Context): HTMLElement {
  const { app } = context, host = h('div', { class: 'stage-middle' });
  live(app.store, host, ['document', 'bodies', 'jobs', 'serial', 'connection', 'body', 'tool', 'undo', 'mode'],
    (state) => whyNothing(context, state), (what) => what && nothingCard(context, what));
  return host;
}

type Nothing = 'connecting' | 'cut away' | 'cut away before' | 'hidden' | 'no solid' | 'why' | 'not built';

/* Why there is nothing to see; null when there is, or when a tool needs the place. */
function whyNothing({ app }: Context, state: State): Nothing | null {
  if (state.connection === 'connecting') return 'connecting';
  const { view } = app.viewport;
  if (view && !view.bare && view.parts.every((part) => part.hidden)) {
    if (view.parts.length > 0) return 'hidden';
    if (state.document.cuts?.length) return state.undo.length > 0 ? 'cut away' : 'cut away before';
  }
  if (state.bodies.length === 0 || state.tool !== 'select' || state.mode === 'surfaces') return null;
  if (!solidOf(state)) return 'no solid';
  const built = app.model.solids.size > 0 || state.bodies.some((body) => body.built.solid || body.shown);
  return built || isBusy(state) ? null : state.bodies[state.body]?.why ? 'why' : 'not built';
}

function nothingCard(context: Context, what: Nothing): HTMLElement {
  const { app } = context, { state } = app.store;
  const last = (state.document.cuts?.length ?? 0) - 1;
  const card = (text: Child, ...actions: Child[]): HTMLElement =>
    h('div', { class: 'stage-card' }, h('p', null, text), actions);
  switch (what) {
    case 'connecting': return card('Opening the document…');
    case 'cut away': return card('The cuts leave nothing of the model.',
      commandButton(context, 'undo', { icon: 'undo', look: 'main' }));
    case 'cut away before': return card('The cuts leave nothing of the model.', button('Remove the last cut',
      () => void app.actions.apply('Remove cut', [{ op: 'cut.remove', index: last }]), { look: 'main' }));
    case 'hidden': return card('All parts are hidden.', commandButton(context, 'show-all', { icon: 'eye', look: 'main' }));
    case 'no solid': return card('This body has no inside yet.', commandButton(context, 'type', { look: 'main' }));
    case 'why': return card(state.bodies[state.body].why,
      button('Add a start for it', () => void addStart(context), { look: 'main' }), commandButton(context, 'type'));
    case 'not built': return card('Nothing is built yet.',
      commandButton(context, 'update', { icon: 'update', look: 'main' }));
  }
}

/* Adds what the body's type needs and the body lacks. */
async function addStart({ app }: Context): Promise<void> {
  const type = solidOf(app.store.state)?.json.type ?? '1-B';
  try {
    const operations = typeOperations(app, type).filter((operation) => operation.op !== 'solid.type');
    if (operations.length > 0) await app.actions.apply('Add a start', operations);
    else app.messages.say(app.store.state.bodies[app.store.state.body]?.why ?? 'Nothing is lacking.', 'warning');
  } catch (reason) {
    app.actions.complain((reason as Error).message);
  }
}
