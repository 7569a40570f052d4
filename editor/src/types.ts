// The five texture types in words (Takayama's thesis 2011, §5.2).

export interface TypeFacts {
  type: string;
  name: string;
  follows: string;
  about: string;
  examples: string;
  exemplar: string;                 // one of the shipped recipes that suits it
}

/** All types, in the thesis's order. */
export const typeTable: readonly TypeFacts[] = [
  { type: '0-A', name: 'Even', follows: 'The same everywhere', exemplar: 'sponge',
    about: 'The same everywhere and in every direction. Only its size is set.', examples: 'Sponge, concrete, bread' },
  { type: '0-B', name: 'Fibres', follows: 'Follows a vector field', exemplar: 'muscle',
    about: 'The same everywhere, but it runs along strokes drawn on the skin and inside.', examples: 'Muscle, bamboo, felt' },
  { type: '0-C', name: 'Flat fibres', follows: 'Follows depth and directions', exemplar: 'flattened',
    about: 'Three sections that differ: across the layers, along the strokes, and across both.',
    examples: 'Flattened fibres, brickwork' },
  { type: '1-A', name: 'Layers', follows: 'Follows depth', exemplar: 'watermelon',
    about: 'Changes from the skin to the core, and looks alike all around.', examples: 'Watermelon, cake, rock' },
  { type: '1-B', name: 'Layers with a grain', follows: 'Follows depth and directions', exemplar: 'kiwi',
    about: 'Changes from the skin to the core, and sections along and across the strokes differ.',
    examples: 'Kiwi, carrot, tree' },
];

/** The facts of a type; undefined for an unknown word. */
export function typeFacts(type: string): TypeFacts | undefined { return typeTable.find((each) => each.type === type); }

/** What a field is called to people. */
export const needWords: { [need: string]: string } = {
  depth: 'depth', direction: 'directions', vectors: 'vectors', scale: 'a size',
};
