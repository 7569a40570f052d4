// The page: its parts put together, and the verbs that go across them.

import type { App } from '../app';
import { Commands } from '../commands';
import { exemplarDialog } from '../dialogs/files';
import { shortcutsDialog, type FirstSteps } from '../dialogs/shortcuts';
import { typeDialog } from '../dialogs/type';
import { installKeyboard } from '../keyboard';
import { Pictures } from '../pictures';
import { focusables, h, recall, remember } from '../ui/dom';
import { installTooltips } from '../ui/floating';
import type { Context } from './context';
import { inspector } from './inspector';
import { stage } from './stage';
import { Session, Workspace } from '../sketch';
import { statusbar } from './statusbar';
import { toolstrip } from './toolstrip';
import { topbar } from './topbar';

/** Builds everything around the view, and lets the keyboard in; gives back what a person can do there, and the sketch. */
export function buildPage(app: App): { commands: Commands; sketch: Workspace } {
  const { store } = app, pictures = new Pictures(app);
  let steps: FirstSteps | null = null;
  const commands = new Commands(app, {
    focusOptions: () => focusables(document.querySelector('.tool-options')!)[0]?.focus(),
    showShortcuts: () => shortcutsDialog(app, commands),
    showHints: () => steps?.show(0),
    chooseType: () => typeDialog(app),
    snapshot: () => {
      const volume = store.state.document.volume !== undefined || store.state.mode === 'volume';
      const { width = 800, height = 600 } = store.state.document[volume ? 'volume' : 'render'] ?? {};
      void pictures.take(volume ? 'volume' : 'render', width, height);
    },
    theme: () => {
      store.set({ theme: store.state.theme === 'dark' ? 'light' : 'dark' });
      remember('theme', store.state.theme);
    },
  });
  const context: Context = {
    app, commands, pictures, chooseType: () => typeDialog(app),
    chooseExemplar: (title, chosen) => exemplarDialog(app, title, chosen),
  };
  app.actions.complain = (message) => app.messages.say(message, 'warning');
  installTheme(app);
  const middle = stage(context), session = new Session(app), sketch = new Workspace(context, session);
  steps = middle.steps;
  const narrow = matchMedia('(max-width: 819px)');
  if (narrow.matches) store.set({ inspector: false });
  document.getElementById('app')!.append(h('div', { class: 'page' }, topbar(context),
    h('div', { class: 'work' }, toolstrip(context), sketch.element, sketch.edge, middle.element,
      inspector(context, session)), statusbar(context)));
  installTooltips();
  // The view shows that it has the focus to those who come by keyboard; a click on it needs no telling.
  const input = (how: string) => (): void => { document.documentElement.dataset.input = how; };
  document.addEventListener('pointerdown', input('pointer'), true);
  document.addEventListener('keydown', input('keys'), true);
  installKeyboard(app, commands);
  return { commands, sketch };
}

/* The first theme is the system's; a choice is remembered. */
function installTheme({ store }: App): void {
  const system = matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark';
  const kept = recall('theme');
  store.set({ theme: kept === 'light' || kept === 'dark' ? kept : system });
  const refresh = (): void => { document.documentElement.dataset.theme = store.state.theme; };
  store.on(['theme'], refresh);
  refresh();
}
