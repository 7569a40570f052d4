// The bar along the top: the document on the left, how it is looked at in the middle, what is being made on the right.

import { sentence } from '../sentences';
import { surfacesOf, type ViewMode } from '../store';
import { button, checkbox, iconButton, segmented } from '../ui/controls';
import { h, set } from '../ui/dom';
import { progress } from '../ui/dialog';
import { menuButton, type MenuItem } from '../ui/floating';
import { icon, type IconName } from '../ui/icons';
import { seconds } from '../ui/numbers';
import { commandButton, refreshCommand, setIcon, type Context } from './context';

/** Builds the bar. */
export function topbar(context: Context): HTMLElement {
  return h('header', { class: 'topbar', role: 'banner' },
    h('div', { class: 'topbar-side' }, documentMenu(context), savedState(context), history(context)),
    modes(context),
    h('div', { class: 'topbar-side end' }, working(context), building(context), pageButtons(context)));
}

function documentMenu(context: Context): HTMLElement {
  const { store } = context.app, title = h('span', { class: 'title-text' }), file = h('span', { class: 'title-file' });
  const made = h('button', { type: 'button', class: 'title', 'aria-label': 'Document' },
    h('img', { src: 'icon.svg', alt: '', width: 22, height: 22 }), h('span', { class: 'title-words' }, title, file),
    icon('down', 12));
  const refresh = (): void => {
    const { document, file: name, saved } = store.state;
    title.textContent = document.title ?? (name || 'pith');
    file.textContent = document.title ? name : '';
    window.document.title = `${saved ? '' : '• '}${title.textContent} – pith`;
  };
  store.on(['document', 'file', 'saved'], refresh);
  refresh();
  const item = (id: string, more: Partial<MenuItem> = {}): MenuItem => {
    const command = context.commands.get(id);
    return { label: command.label, keys: command.keys[0], disabled: (command.why?.() ?? null) !== null,
      run: () => context.commands.run(id), ...more };
  };
  return menuButton(made, () => [
    item('save', { icon: 'save' }), item('save-as'), item('revert', { icon: 'return' }), null,
    item('snapshot', { icon: 'camera' }), item('theme', { icon: 'sun' }), item('shortcuts', { icon: 'help' }), item('hints'),
  ]);
}

function savedState(context: Context): HTMLElement {
  const { store } = context.app, text = h('span', { class: 'saved-text' });
  const made = button(text, () => context.commands.run('save'),
    { look: 'plain', class: 'saved', keys: context.commands.get('save').keys[0] });
  made.prepend(h('span', { class: 'dot', 'aria-hidden': 'true' }));
  const refresh = (): void => {
    const { saved, recovered, connection } = store.state;
    const word = saved ? 'Saved' : recovered ? 'Recovered' : 'Unsaved';
    text.textContent = connection === 'connecting' ? 'Opening…' : word;
    made.dataset.saved = String(saved);
    made.dataset.tip = saved ? 'Everything is in the file.'
      : recovered ? 'Changes of an earlier time were recovered; they are not in the file yet. Undo goes back to it.'
      : 'There are changes that are not in the file yet. Save';
  };
  store.on(['saved', 'recovered', 'connection'], refresh);
  refresh();
  return made;
}

function history(context: Context): HTMLElement {
  const { store } = context.app;
  const undo = commandButton(context, 'undo', { only: 'icon', icon: 'undo', look: 'plain' });
  const redo = commandButton(context, 'redo', { only: 'icon', icon: 'redo', look: 'plain' });
  const refresh = (): void => {
    refreshCommand(context, undo, 'undo', `Undo: ${store.state.undo[0]}`);
    refreshCommand(context, redo, 'redo', `Redo: ${store.state.redo[0]}`);
  };
  store.on(['undo', 'redo'], refresh);
  refresh();
  return h('div', { class: 'pair', role: 'group', 'aria-label': 'History' }, undo, redo);
}

function modes(context: Context): HTMLElement {
  const { store } = context.app, [keys] = context.commands.get('mode').keys;
  const control = segmented<ViewMode>('View', [
    { value: 'solid', label: 'Solid', icon: 'solid', tip: 'The model with its inside', keys },
    { value: 'depth', label: 'Depth', icon: 'drop', tip: 'Depth: red outside, blue at the core', keys },
    { value: 'shape', label: 'Shape', icon: 'shape', tip: 'The bare shape', keys },
    { value: 'volume', label: 'Volume', icon: 'cloud', tip: 'Seen through', keys },
    { value: 'surfaces', label: 'Surfaces', icon: 'nested', tip: 'The surfaces that colours flow from', keys },
  ], store.state.mode, (mode) => store.set({ mode }), { key: 'mode' });
  store.on(['mode'], () => control.set(store.state.mode));
  const within = control.element.querySelector<HTMLElement>('[data-key="mode=surfaces"]')!;
  const refresh = (): void => { within.hidden = store.state.bodies.every((_, i) => surfacesOf(store.state, i).length === 0); };
  store.on(['document', 'bodies'], refresh);
  refresh();
  control.element.classList.add('modes');
  return control.element;
}

/* What is being made, how far it is, and the way to stop it. */
function working(context: Context): HTMLElement {
  const { store } = context.app, bar = progress('Progress'), text = h('span', { class: 'job-text' });
  const stop = iconButton('close', 'Cancel', () => context.commands.run('cancel'), { look: 'plain' });
  const made = h('div', { class: 'job', role: 'status' }, h('div', { class: 'job-words' }, text, bar.element), stop);
  const refresh = (): void => {
    const { jobs } = store.state;
    const job = jobs.find((each) => each.state === 'running') ?? jobs.find((each) => each.state === 'waiting');
    made.hidden = !job;
    if (!job) return;
    text.textContent = job.state === 'waiting' ? 'Waiting…' : job.text || 'Working…';
    bar.set(job.state === 'waiting' || job.fraction <= 0 ? NaN : job.fraction);
  };
  store.on(['jobs'], refresh);
  refresh();
  return made;
}

function building(context: Context): HTMLElement {
  const { app } = context, { store } = app;
  const update = commandButton(context, 'update', { icon: 'update', look: 'main', class: 'update' });
  const automatic = checkbox('Auto', store.state.automatic, () => context.commands.run('automatic'),
    { key: 'automatic', tip: 'Update after every change that calls for it', look: 'switch' });
  const refresh = (): void => {
    const due = context.commands.get('update').why?.() === null;
    refreshCommand(context, update, 'update', 'Fill the model with what the document says now');
    update.classList.toggle('due', due);
    automatic.set(store.state.automatic);
  };
  store.on(['bodies', 'automatic', 'jobs'], refresh);
  refresh();
  let announced = 0;
  store.on(['jobs'], () => {
    for (const job of store.state.jobs) {
      if (job.job <= announced || !['done', 'failed'].includes(job.state)) continue;
      announced = job.job;
      if (job.state === 'failed') app.messages.say(sentence(job.message ?? `${job.what} failed.`), 'warning');
      else if (job.notes) app.messages.say(job.notes);
    }
  });
  return h('div', { class: 'pair building', role: 'group', 'aria-label': 'Build' }, update, automatic.element);
}

function pageButtons(context: Context): HTMLElement {
  const { store } = context.app;
  // The document's menu has the first three too: narrow windows leave them to it.
  const buttonOf = (id: string, name: IconName, look = ''): HTMLButtonElement =>
    commandButton(context, id, { only: 'icon', icon: name, look: 'plain', class: look });
  const snapshot = buttonOf('snapshot', 'camera', 'page-more'), theme = buttonOf('theme', 'sun', 'page-more');
  const help = buttonOf('shortcuts', 'help', 'page-more'), inspector = buttonOf('inspector', 'sidebar');
  const refresh = (): void => {
    setIcon(theme, store.state.theme === 'dark' ? 'sun' : 'moon');
    theme.dataset.tip = store.state.theme === 'dark' ? 'Light page' : 'Dark page';
    set(inspector, 'aria-pressed', store.state.inspector);
    inspector.dataset.tip = store.state.inspector ? 'Hide the inspector' : 'Show the inspector';
  };
  store.on(['theme', 'inspector'], refresh);
  refresh();
  return h('div', { class: 'pair' }, snapshot, theme, help, inspector);
}

/** What a finished job took, in words: "shape 0.1 s, fill 1.2 s". */
export function stageTimes(times: { [stage: string]: number } | undefined): string {
  const taken = Object.entries(times ?? {}).filter(([, time]) => time >= 0.0005);
  return taken.map(([stage, time]) => `${stage} ${seconds(time)}`).join(', ');
}
