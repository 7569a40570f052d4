// The tools as people meet them: name, letter, picture, a line of help, and why one is of no use at the moment.

import { bodyJson, solidOf, type State, type ToolName } from '../store';
import type { IconName } from '../ui/icons';

export interface ToolFacts {
  name: ToolName;
  label: string;
  key: string;
  icon: IconName;
  hint: string;                     // for the status bar
  about: string;                    // for the tooltip
  group: number;                    // tools of a group stand together
}

/** All tools, in the order of the strip. */
export const toolTable: readonly ToolFacts[] = [
  { name: 'select', label: 'Select', key: 'V', icon: 'select', group: 0, about: 'Look around and pick parts.',
    hint: 'Click a part to pick it. Drag to turn, Shift+drag to move, wheel to zoom.' },
  { name: 'cut', label: 'Cut', key: 'C', icon: 'cut', group: 1, about: 'Draw a line across the model.',
    hint: 'Draw a line across the model; it is cut along it, away from you. A closed line takes a core out.' },
  { name: 'plane', label: 'Cut plane', key: 'P', icon: 'plane', group: 1, about: 'Look inside with a plane, and cut along it.',
    hint: 'Drag the plane along its arrow or turn it; double-click cuts along it.' },
  { name: 'fill', label: 'Fill faces', key: 'G', icon: 'fill', group: 2,
    about: 'Paint a face and its neighbours with a depth, up to creases.',
    hint: 'Click a face to paint it and what is reached from it without crossing a crease.' },
  { name: 'face', label: 'Paint faces', key: 'T', icon: 'face', group: 2, about: 'Paint single triangles with a depth.',
    hint: 'Click a triangle to paint it; drag to paint on.' },
  { name: 'depth', label: 'Depth stroke', key: 'B', icon: 'depth', group: 2,
    about: 'Draw a stroke of one depth on the skin, a section or a layer.',
    hint: 'Draw a stroke of the chosen depth on the skin, a section or a layer.' },
  { name: 'points', label: 'Depth points', key: 'O', icon: 'points', group: 2, about: 'Place points of one depth.',
    hint: 'Click to place a point of the chosen depth on the skin, a section or a layer.' },
  { name: 'direction', label: 'Direction', key: 'D', icon: 'direction', group: 3,
    about: 'Draw strokes that fibres follow.',
    hint: 'Draw strokes along the fibres: on layers, on sections, or on the skin. Wheel over a layer: deeper or shallower.' },
  { name: 'scale', label: 'Texture size', key: 'S', icon: 'scale', group: 4,
    about: 'Place the exemplar on the model and set its size there.',
    hint: 'Drag the exemplar over the model, wheel changes its size, double-click sets it there.' },
  { name: 'paste', label: 'Paste', key: 'A', icon: 'paste', group: 4, about: 'Set an exemplar on top by hand.',
    hint: 'Drag to move, Shift+drag to turn, wheel for the size, double-click to paste.' },
];

/** The facts of a tool. */
export function toolFacts(name: ToolName): ToolFacts { return toolTable.find((tool) => tool.name === name)!; }

/** Why a tool is of no use to the chosen body, a sentence; null when it is. */
export function toolObstacle(state: State, name: ToolName): string | null {
  if (name === 'select' || name === 'cut' || name === 'plane') return null;
  const solid = solidOf(state)?.json;
  if (solid && solid.kind !== 'lapped') return `This body is made of a voxel grid, which needs no ${wants[name]}.`;
  if (!solid) return name === 'paste' ? 'This body has no solid to paste on yet; choose a texture type first.' : null;
  const type = (solid.type ?? '1-B') as string, needs = state.types[type];
  if (!needs) return null;
  if (name === 'scale') return needs.scale ? null : `Type ${type} takes its size from the depth field.`;
  if (name === 'paste') return null;
  if (name === 'direction') {
    return needs.direction || needs.vectors ? null : `Type ${type} turns each patch at random; it follows no directions.`;
  }
  return needs.depth ? null : `Type ${type} does not follow depth.`;
}

const wants: { [name in ToolName]?: string } = {
  fill: 'depth', face: 'depth', depth: 'depth', points: 'depth', direction: 'directions', scale: 'size', paste: 'pastes',
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
