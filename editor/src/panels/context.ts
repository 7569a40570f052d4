// What panels share beyond the app.

import type { App } from '../app';
import type { Commands } from '../commands';
import type { Pictures } from '../pictures';
import type { ToolName } from '../store';
import { button, iconButton, type ButtonLook } from '../ui/controls';
import { set } from '../ui/dom';
import { icon, type IconName } from '../ui/icons';

export interface Context {
  app: App;
  commands: Commands;
  pictures: Pictures;
  /** Opens the dialog of texture types for the chosen body. */
  chooseType(): void;
  /** Opens the dialog of exemplars; gives what was chosen, as a document writes it. */
  chooseExemplar(title: string, chosen: (exemplar: { [key: string]: unknown }) => void): void;
}

/** A button that does a command: its label, shortcut and, while it cannot be done, the reason are the command's. */
export function commandButton(context: Context, id: string, look: ButtonLook & { only?: 'icon' } = {}): HTMLButtonElement {
  const command = context.commands.get(id), run = (): void => context.commands.run(id);
  const made = look.only === 'icon'
    ? iconButton(look.icon ?? 'check', command.label, run, { keys: command.keys[0], key: id, ...look })
    : button(command.label, run, { tip: command.label, keys: command.keys[0], key: id, ...look });
  return made;
}

/** Shows whether a command can be done at the moment; the button stays within reach and says why not. */
export function refreshCommand(context: Context, made: HTMLButtonElement, id: string, tip?: string): void {
  const command = context.commands.get(id), why = command.why?.() ?? null;
  set(made, 'aria-disabled', why !== null);
  made.dataset.tip = why ?? tip ?? command.label;
}

/** For rows of lists: what a row is about is marked in the view while it is pointed at. */
export function pointAt({ store }: App, name: string): (on: boolean) => void {
  return (on) => { if (on || store.state.pointed === name) store.set({ pointed: on ? name : null }); };
}

/** The letter of a tool, as shortcuts are shown. */
export function keyOf(context: Context, name: ToolName): string | undefined {
  return context.app.toolbox.get(name)?.key.toUpperCase();
}

/** Changes the icon of a button. */
export function setIcon(made: HTMLButtonElement, name: IconName, size = 18): void {
  made.querySelector('svg')?.replaceWith(icon(name, size));
}
