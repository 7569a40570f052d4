import type { App } from '../app';
export function buildPage(app: App): void {
  document.getElementById('app')!.append(app.viewport.element);
}
