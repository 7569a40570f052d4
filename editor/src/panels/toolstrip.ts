// The strip of tools along the left edge.

import type { ToolName } from '../store';
import { rove } from '../ui/controls';
import { h, set } from '../ui/dom';
import { icon, isIcon } from '../ui/icons';
import { toolObstacle, toolTable } from '../tools/table';
import type { Context } from './context';

/** Builds the strip; tools that are of no use to the chosen body stay in their place and say why. */
export function toolstrip(context: Context): HTMLElement {
  const { app } = context, { store, toolbox } = app, buttons = new Map<ToolName, HTMLButtonElement>();
  const groups: HTMLElement[] = [];
  for (const { name, about, group } of toolTable) {
    const tool = toolbox.get(name);
    if (!tool) continue;
    const made = h('button', {
      type: 'button', role: 'radio', class: 'tool', 'aria-label': tool.label, 'data-tip-keys': tool.key.toUpperCase(),
      onclick: () => {
        const obstacle = toolObstacle(store.state, name);
        if (obstacle) app.messages.say(obstacle);
        else store.set({ tool: name });
      },
    }, icon(isIcon(tool.icon) ? tool.icon : 'select', 22));
    made.dataset.about = `${tool.label}: ${about.charAt(0).toLowerCase()}${about.slice(1)}`;
    buttons.set(name, made);
    (groups[group] ??= h('div', { class: 'tool-group' })).append(made);
  }
  const refresh = (): void => {
    for (const [name, made] of buttons) {
      const obstacle = toolObstacle(store.state, name), chosen = store.state.tool === name;
      set(made, 'aria-checked', chosen);
      set(made, 'aria-disabled', obstacle !== null);
      made.tabIndex = chosen ? 0 : -1;
      made.dataset.tip = obstacle ?? made.dataset.about;
    }
    if (toolObstacle(store.state, store.state.tool)) store.set({ tool: 'select' });
  };
  store.on(['tool', 'document', 'body', 'types'], refresh);
  refresh();
  const all = [...buttons.values()];
  const sketch = h('button', { type: 'button', class: 'tool sketch-toggle', 'aria-label': 'Sketch', 'data-tip': 'Sketch: draw surfaces along and across an axis',
    'data-tip-keys': context.commands.get('sketch').keys[0], onclick: () => context.commands.run('sketch') }, icon('sketch', 22));
  const pressed = (): void => set(sketch, 'aria-pressed', store.state.sketching);
  store.on(['sketching'], pressed);
  pressed();
  const strip = h('nav', { class: 'toolstrip', 'aria-label': 'Tools', 'data-tips': 'right' }, sketch,
    h('div', { role: 'radiogroup', 'aria-label': 'Tools' }, groups));
  strip.addEventListener('keydown', (event) => rove(event, all));
  return strip;
}
