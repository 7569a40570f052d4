// The list of shortcuts, made from the tables of tools and commands, so that it is always what the keyboard does.

import type { App } from '../app';
import type { Command, Commands } from '../commands';
import { button } from '../ui/controls';
import { h, recall, remember, type Child } from '../ui/dom';
import { openDialog } from '../ui/dialog';
import { shortcut } from '../ui/floating';
import { icon } from '../ui/icons';

/** Opens the list. */
export function shortcutsDialog(app: App, commands: Commands): void {
  const groups = new Map<string, Command[]>();
  for (const command of commands.all) {
    if (command.keys.length) groups.set(command.group, [...(groups.get(command.group) ?? []), command]);
  }
  const tools = app.toolbox.tools.map((tool) => line(tool.label, [tool.key.toUpperCase()]));
  openDialog({ title: 'Keyboard shortcuts', class: 'wide', body: h('div', { class: 'shortcuts' },
    block('Tools', tools), [...groups].map(([name, all]) =>
      block(name, all.map((command) => line(command.label, command.keys)))),
    block('With the mouse', [
      line('Turn', ['Drag beside the model', 'Right drag']), line('Move', ['Shift+drag', 'Middle drag']),
      line('Nearer, further', ['Wheel']),
    ])) });
}

function block(name: string, lines: Child): HTMLElement {
  return h('section', null, h('h3', null, name), h('dl', null, lines));
}

function line(label: string, keys: string[]): Child {
  return h('div', null, h('dt', null, label), h('dd', null,
    keys.map((each, i) => [i > 0 && ' or ', h('kbd', null, shortcut(each))])));
}

/* ---- first steps ------------------------------------------------------------------------------------------------- */

const steps: [string, string][] = [
  ['Look inside', 'Press C and draw a line across the model: it is cut along it. Drag beside the model to turn it, ' +
    'wheel to come nearer.'],
  ['Say what the inside follows',
    'Y chooses a texture type. Paint the outside, draw the core and the fibres with the tools on the left.'],
  ['Change it and see', 'The inspector on the right holds everything the document says. Update fills the model anew; ' +
    'undo goes back as far as you like.'],
];

/** Three short steps over the view, shown until they were read once; `again` shows them anyway. */
export class FirstSteps {
  readonly element = h('aside', { class: 'first-steps', 'aria-label': 'First steps', hidden: true });

  constructor() { if (recall('hints') !== 'seen') this.show(0); }

  /** Shows a step, from 0. */
  show(at: number): void {
    const last = at === steps.length - 1, done = (): void => { remember('hints', 'seen'); this.element.hidden = true; };
    const next = button(last ? 'Got it' : 'Next',
      () => { if (last) return done(); this.show(at + 1); this.element.querySelector<HTMLElement>('.main')?.focus(); },
      { look: 'main' });
    this.element.hidden = false;
    this.element.replaceChildren(
      h('div', { class: 'steps-dots', 'aria-hidden': 'true' },
        steps.map((_, i) => h('span', { class: i === at ? 'on' : '' }))),
      h('h3', null, steps[at][0]), h('p', null, steps[at][1]),
      h('div', { class: 'actions end' }, !last && button('Skip', done, { look: 'plain' }), next));
    this.element.prepend(icon('info', 18));
  }
}
