// The middle of the page: the view, and what lies over it.

import { takeDroppedFiles } from '../dialogs/files';
import { FirstSteps } from '../dialogs/shortcuts';
import { button } from '../ui/controls';
import { h, live, set } from '../ui/dom';
import { icon } from '../ui/icons';
import { write } from '../ui/numbers';
import { paletteCss } from '../view/looks';
import { typeOperations } from '../dialogs/type';
import { bodyJson, solidOf } from '../store';
import { commandButton, type Context } from './context';
import { isBusy } from './inside';
import { toolOptions } from './tooloptions';

/** Builds the middle; gives the first steps back, which a command shows again. */
export function stage(context: Context): { element: HTMLElement; steps: FirstSteps } {
  const { app } = context, steps = new FirstSteps();
  const element = h('main', { class: 'stage', 'aria-label': 'Model' }, app.viewport.element, lostBanner(context),
    h('div', { class: 'stage-top' }, toolOptions(context)), depthScale(context), middle(context),
    h('div', { class: 'stage-low' }, steps.element, app.messages.element));
  takeDroppedFiles(app);
  return { element, steps };
}

function lostBanner({ app }: Context): HTMLElement {
  const text = h('span'), banner = h('div', { class: 'banner', role: 'alert' }, icon('warning', 18), text);
  const refresh = (): void => {
    const { connection } = app.store.state;
    banner.hidden = connection === 'open' || connection === 'connecting';
    text.textContent = connection === 'refused'
      ? 'This page belongs to an earlier run of pith. Open the address that “pith edit” printed last.'
      : 'The connection to pith is lost; it is being looked for. What you did so far is kept beside the document.';
  };
  app.store.on(['connection'], refresh);
  refresh();
  return banner;
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
  const made = h('div', { class: 'depth-scale' }, h('span', { class: 'scale-end' }, 'outside'), track,
    h('span', { class: 'scale-end' }, 'core'));
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
    made.hidden = !depth || !(mode === 'depth' || layer !== null
      || ['fill', 'face', 'depth', 'points', 'direction'].includes(tool));
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
  live(app.store, host, ['document', 'bodies', 'jobs', 'serial', 'connection', 'body', 'tool'], (state) => {
    if (state.connection === 'connecting') return 'connecting';
    if (state.bodies.length === 0 || state.tool !== 'select') return null; // a tool needs the place
    if (!solidOf(state)) return 'no solid';
    const built = app.model.solids.size > 0 || state.bodies.some((body) => body.built.solid || body.shown);
    return built || isBusy(state) ? null : state.bodies[state.body]?.why ? 'why' : 'not built';
  }, (what) => {
    if (what === 'connecting') return h('p', { class: 'stage-card' }, 'Opening the document…');
    if (what === 'no solid') {
      return h('div', { class: 'stage-card' }, h('p', null, 'This body has no inside yet.'),
        commandButton(context, 'type', { look: 'main' }));
    }
    if (what === 'why') {
      return h('div', { class: 'stage-card' }, h('p', null, app.store.state.bodies[app.store.state.body].why),
        button('Add a start for it', () => void addStart(context), { look: 'main' }), commandButton(context, 'type'));
    }
    if (what === 'not built') return h('div', { class: 'stage-card' }, h('p', null, 'Nothing is built yet.'),
      commandButton(context, 'update', { icon: 'update', look: 'main' }));
    return null;
  });
  return host;
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
