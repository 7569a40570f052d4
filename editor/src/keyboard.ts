// The keyboard: finds the command or the tool of a key.

import type { App } from './app';
import type { Commands } from './commands';
import { toolObstacle } from './tools/table';

/** Does a pressed key match a shortcut such as "Ctrl+Shift+Z", "?", "1" or "Delete"? Letters go by what the key writes,
    digits by where it is, so that both work on any layout. */
export function matches(event: KeyboardEvent, keys: string): boolean {
  const parts = keys === '+' ? ['+'] : keys.split('+'), key = parts.pop()!;
  const wants = (name: string): boolean => parts.includes(name);
  if (wants('Ctrl') !== (event.ctrlKey || event.metaKey) || wants('Alt') !== event.altKey) return false;
  if (/^\d$/.test(key)) {
    return wants('Shift') === event.shiftKey && (event.code === `Digit${key}` || event.code === `Numpad${key}`);
  }
  if (key === 'Space') return event.key === ' ' && !event.shiftKey;
  // Signs such as ? need the shift key on some keyboards and not on others.
  if (key.length === 1 && !/[a-z]/i.test(key)) return event.key === key;
  return wants('Shift') === event.shiftKey && event.key.toLowerCase() === key.toLowerCase();
}

const typing = 'input:not([type=range]):not([type=checkbox]):not([type=color]), textarea, select, [contenteditable]';
const pressing = 'button, a, input, summary, [role=slider], [role=tab], [role=menuitem], [role=separator]';

/** Listens to the whole page; keys typed into fields, and those a focused control uses itself, stay theirs. */
export function installKeyboard(app: App, commands: Commands): void {
  document.addEventListener('keydown', (event) => {
    // A dialog lets none through, also where Tab has left it for the browser's own buttons.
    if (event.defaultPrevented || document.querySelector('dialog[open]')) return;
    const target = event.target as Element;
    if (target.matches(typing) && !(event.ctrlKey && event.key.toLowerCase() === 's')) return;
    if ((event.key === ' ' || event.key === 'Enter' || event.key.startsWith('Arrow'))
      && target.matches(pressing)) return;
    if (event.key === 'Enter' && app.store.state.tool === 'plane') {
      (app.toolbox.get('plane') as unknown as { commit(keep: string): void }).commit('negative');
      return;
    }
    const command = commands.all.find((each) => each.keys.some((keys) => matches(event, keys)));
    if (command) {
      event.preventDefault();
      commands.run(command.id);
      return;
    }
    const tool = app.toolbox.tools.find((each) => matches(event, each.key));
    if (!tool) return;
    event.preventDefault();
    const obstacle = toolObstacle(app.store.state, tool.name);
    if (obstacle) app.messages.say(obstacle);
    else app.store.set({ tool: tool.name });
  });
}
