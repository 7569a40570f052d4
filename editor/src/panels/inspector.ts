// The inspector along the right edge: five tabs of sections, as wide as one likes, a drawer on narrow windows.

import type { State, ToolName } from '../store';
import { h, recall, remember } from '../ui/dom';
import { splitter, tabs } from '../ui/layout';
import type { Context } from './context';
import { cutsPanel } from './cuts';
import { fieldsPanel } from './fields';
import { insidePanel } from './inside';
import { lookPanel } from './look';
import { recipeSection } from './recipe';
import { shapeSection } from './shape';
import { sketchPanel, type Session } from '../sketch';

const widths: [number, number] = [264, 560];

/* Where the tool's work shows. */
const tabOf: { [tool in ToolName]?: State['tab'] } = {
  cut: 'cuts', plane: 'cuts', fill: 'fields', face: 'fields', depth: 'fields', points: 'fields', direction: 'fields',
  scale: 'fields', paste: 'inside',
};

/** Builds the inspector with its edge. */
export function inspector(context: Context, session: Session): HTMLElement[] {
  const { store } = context.app;
  const panels = { inside: insidePanel(context, recipeSection(context), shapeSection(context)),
    fields: fieldsPanel(context), sketch: sketchPanel(context, session), cuts: cutsPanel(context), look: lookPanel(context) };
  const bar = tabs('Inspector', [
    { id: 'inside', label: 'Inside', icon: 'solid', panel: panels.inside },
    { id: 'fields', label: 'Fields', icon: 'lines', panel: panels.fields },
    { id: 'sketch', label: 'Sketch', icon: 'sketch', panel: panels.sketch },
    { id: 'cuts', label: 'Cuts', icon: 'cut', panel: panels.cuts },
    { id: 'look', label: 'Look', icon: 'camera', panel: panels.look },
  ], store.state.tab, (tab) => store.set({ tab: tab as State['tab'] }));
  const scroll = h('div', { class: 'inspector-scroll' }, Object.values(panels));
  const element = h('aside', { class: 'inspector', 'aria-label': 'Inspector' }, bar.element, scroll);
  let width = Number(recall('width')) || 328;
  const resize = (next: number): void => {
    width = next;
    element.style.setProperty('--width', `${width}px`);
    remember('width', String(width));
  };
  const edge = splitter('Width of the inspector', () => width, resize, widths);
  resize(width);
  const refresh = (): void => { element.hidden = edge.hidden = !store.state.inspector; };
  store.on(['inspector'], refresh);
  store.on(['tab'], () => { bar.show(store.state.tab); scroll.scrollTop = 0; });
  store.on(['tool'], () => { const tab = tabOf[store.state.tool]; if (tab) store.set({ tab }); });
  refresh();
  return [edge, element];
}
