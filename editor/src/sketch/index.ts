// The sketch of surfaces that colours flow between (Takayama 2011, §6.3), as the page builds it in.

export { sketchPanel } from './panel';
export { Session } from './session';
export { Workspace } from './workspace';
