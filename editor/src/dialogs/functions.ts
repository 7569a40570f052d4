// The dialog of functions: what a node may compute, grouped by what it is for, each with its sentence.

import type { App } from '../app';
import { functionSchema, Graph, obstacle } from '../graph';
import type { Functions } from '../protocol';
import { labelOf } from '../schema';
import { solidOf } from '../store';
import { rove } from '../ui/controls';
import { fill, h } from '../ui/dom';
import { openDialog } from '../ui/dialog';

/* Told from what functions give and take. */
const groups: { title: string; has: (facts: Functions[string]) => boolean }[] = [
  { title: 'Patterns', has: ({ gives, inputs }) => gives !== 'point' && inputs.some((input) => input.name === 'at') },
  { title: 'Numbers', has: ({ gives }) => gives === 'number' },
  { title: 'Colours', has: ({ gives }) => gives === 'colour' },
  { title: 'Places and directions', has: ({ gives }) => gives === 'point' },
];

/** Opens the dialog; `chosen` is told the function. name: of a node that becomes it; null: of a new one. */
export function functionDialog(app: App, title: string, name: string | null, chosen: (from: string) => void): void {
  const { functions, schema } = app.store.state, solid = solidOf(app.store.state)?.json ?? {};
  const graph = new Graph(solid, functions), node = name === null ? null : graph.nodes[graph.indexOf(name)];
  const search = h('input', { type: 'search', class: 'field', placeholder: 'Find a function', 'aria-label': 'Find a function',
    oninput: () => show() });
  const host = h('div', { class: 'function-groups' });
  const use = (from: string): void => { close(); chosen(from); };

  function show(): void {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean), left = new Set(Object.keys(functions));
    const buttons: HTMLButtonElement[] = [];
    const made = groups.map(({ title: head, has }) => {
      const own = [...left].filter((from) => has(functions[from]));
      for (const from of own) left.delete(from);
      const hits = own.filter((from) => words.every((word) => `${from} ${about(from)}`.toLowerCase().includes(word)));
      if (hits.length === 0) return null;
      return h('section', { class: 'function-group' }, h('h3', null, head), h('ul', null, hits.map((from) => {
        const why = node ? obstacle(graph, functions, node, from) : null;
        const entry = h('button', { type: 'button', class: 'function', 'data-function': from, disabled: why !== null,
          'aria-current': node?.function === from ? 'true' : null, onclick: () => use(from) },
        h('span', { class: 'function-name' }, labelOf(from)), h('span', { class: 'function-about' }, why ?? about(from)));
        if (why === null) buttons.push(entry);
        return h('li', null, entry);
      })));
    });
    fill(host, made.some(Boolean) ? made : h('p', { class: 'quiet' }, 'No function is called so.'));
    host.onkeydown = (event) => rove(event, buttons, false);
    search.onkeydown = (event) => {
      if (event.key === 'Enter' && buttons.length > 0) { event.preventDefault(); buttons[0].click(); }
      if (event.key === 'ArrowDown' && buttons.length > 0) { event.preventDefault(); buttons[0].focus(); }
    };
  }
  const about = (from: string): string => ((functionSchema(schema, from).description ?? '') as string).replace(/`([^`]*)`/g, '“$1”');
  const close = openDialog({ title, body: [search, host], class: 'wide functions' });
  show();
  search.focus();
}
