// The order of the tools, what each is for, and why one is of no use to the chosen body.

import type { Json } from '../protocol';
import { bodyJson, solidOf, surfacesOf, type State, type ToolName } from '../store';

export interface ToolFacts {
  name: ToolName;
  about: string;                    // for the tooltip
  group: number;                    // tools of a group stand together
}

/** All tools, in the order of the strip. */
export const toolTable: readonly ToolFacts[] = [
  { name: 'select', group: 0, about: 'Pick parts and pull them about.' },
  { name: 'cut', group: 1, about: 'Draw a line across the model to cut it.' },
  { name: 'plane', group: 1, about: 'Look inside with a plane, and cut along it.' },
  { name: 'fill', group: 2, about: 'Paint a face and its neighbours with a depth, up to creases.' },
  { name: 'face', group: 2, about: 'Paint single triangles with a depth.' },
  { name: 'depth', group: 2, about: 'Draw a stroke of one depth on the skin, a section or a layer.' },
  { name: 'points', group: 2, about: 'Place points of one depth.' },
  { name: 'direction', group: 3, about: 'Draw strokes that fibres follow.' },
  { name: 'scale', group: 4, about: 'Place the exemplar on the model and set its size there.' },
  { name: 'paste', group: 4, about: 'Set an exemplar on top by hand.' },
  { name: 'paint-surface', group: 5, about: 'Paint the colours of surfaces inside, and how they blur.' },
  { name: 'erase-surface', group: 5, about: 'Take a part of a surface away.' },
];

/** Why a tool is of no use to the chosen body, a sentence; null when it is. */
export function toolObstacle(state: State, name: ToolName): string | null {
  if (name === 'select' || name === 'cut' || name === 'plane') return null;
  if (name === 'paint-surface' || name === 'erase-surface') {
    return surfacesOf(state).length ? null : 'This body has no surfaces that colours flow from; draw some first.';
  }
  const solid = solidOf(state)?.json;
  if (solid?.kind === 'diffusion') return `This body’s colours flow between its surfaces; it needs no ${wants[name]}.`;
  if (solid?.kind === 'procedural') return computedObstacle(solid, name);
  if (solid && solid.kind !== 'lapped') return `This body is made of a voxel grid, which needs no ${wants[name]}.`;
  if (!solid) return name === 'paste' ? 'This body has no solid to paste on yet; choose a texture type first.' : null;
  const type = (solid.type ?? '1-B') as string, needs = state.types[type];
  if (!needs) return null;
  if (name === 'scale') return needs.scale ? null : `Type ${type} takes its size from the depth field.`;
  if (name === 'paste') return null;
  if (name === 'direction') {
    return needs.direction || needs.vectors ? null
      : `Type ${type} turns each patch at random; it follows no directions.`;
  }
  return needs.depth ? null : `Type ${type} does not follow depth.`;
}

/* A computed solid follows what its functions say; of the fields only directions, and these only when one asks. */
function computedObstacle(solid: Json, name: ToolName): string | null {
  const directed = ((solid.nodes ?? []) as Json[]).some((node) => node.function === 'direction');
  if (name === 'direction') {
    return directed ? null : 'This body is computed, and none of its functions is “direction”; add one to follow strokes.';
  }
  if (directed && name !== 'scale' && name !== 'paste') return null; // directions lie within the layers of depth
  if (name === 'scale') return 'This body is computed: its sizes are in its graph, under “Inside”.';
  if (name === 'paste') return 'This body is computed; only bodies filled with an exemplar can be pasted on.';
  return 'This body is computed from the place alone; it does not follow depth.';
}

const wants: { [name in ToolName]?: string } = {
  fill: 'depth', face: 'depth', depth: 'depth', points: 'depth', direction: 'directions', scale: 'size',
  paste: 'pastes',
};

/** Which field the direction tool draws into, for a stroke on a kind of surface; null when the body's type follows
    none. Type 0-B follows vectors on the skin and inside, 0-C and 1-B follow directions within the layers. */
export function directionList(state: State, kind: 'skin' | 'section' | 'layer'):
  'direction' | 'vectors.surface' | 'vectors.inside' | null {
  const type = (solidOf(state)?.json.type ?? '1-B') as string, needs = state.types[type];
  if (needs?.vectors) return kind === 'skin' ? 'vectors.surface' : 'vectors.inside';
  if (needs?.direction || bodyJson(state).depth) return 'direction';
  return null;
}
