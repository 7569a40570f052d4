// The sheet over the picture: strokes under way, strokes and points of the document, the clip plane's handle. Drawn in
// two dimensions, so that what a hand does shows at once, however long the picture behind takes.

import * as THREE from 'three';

/** Something to draw: a polyline or points of the world, or of the screen (CSS pixels) when `flat`. */
export interface Mark {
  points: THREE.Vector3[] | { x: number; y: number }[];
  colour: string;
  width?: number;
  dots?: number;          // radius of points instead of a line
  arrow?: boolean;
  dashed?: boolean;
  flat?: boolean;
  closed?: boolean;
  fill?: string;
  label?: string;
}

export class Overlay {
  readonly canvas = document.createElement('canvas');
  private readonly lists = new Map<string, Mark[]>();
  private width = 1;
  private height = 1;

  constructor(private readonly camera: THREE.PerspectiveCamera) { this.canvas.className = 'overlay'; }

  /** Replaces the marks of this name; null takes them away. */
  show(name: string, marks: Mark[] | null): void {
    if (marks) this.lists.set(name, marks);
    else this.lists.delete(name);
    this.draw();
  }

  resize(width: number, height: number, ratio: number): void {
    this.width = width;
    this.height = height;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  /** A point of the world in CSS pixels; null behind the eye. */
  project(point: THREE.Vector3): { x: number; y: number } | null {
    const at = point.clone().applyMatrix4(this.camera.matrixWorldInverse);
    if (at.z > -this.camera.near * 0.5) return null;
    at.applyMatrix4(this.camera.projectionMatrix);
    return { x: (at.x * 0.5 + 0.5) * this.width, y: (0.5 - at.y * 0.5) * this.height };
  }

  draw(): void {
    const brush = this.canvas.getContext('2d')!;
    // Chromium may go on showing a sheet that was only cleared.
    this.canvas.style.visibility = this.lists.size > 0 ? '' : 'hidden';
    brush.setTransform(1, 0, 0, 1, 0, 0);
    brush.clearRect(0, 0, this.canvas.width, this.canvas.height);
    brush.scale(this.canvas.width / this.width, this.canvas.height / this.height);
    brush.lineJoin = brush.lineCap = 'round';
    for (const marks of this.lists.values()) for (const mark of marks) this.drawMark(brush, mark);
  }

  private drawMark(brush: CanvasRenderingContext2D, mark: Mark): void {
    const at = mark.flat ? (mark.points as { x: number; y: number }[])
                         : (mark.points as THREE.Vector3[]).map((p) => this.project(p)).filter((p) => p !== null);
    if (at.length === 0) return;
    if (mark.dots) for (const p of at) this.drawDot(brush, p, mark.dots, mark.colour);
    else this.drawLine(brush, at, mark);
    if (mark.label) {
      brush.font = '600 12px system-ui, sans-serif';
      this.outlined(brush, () => brush.strokeText(mark.label!, at[at.length - 1].x + 8, at[at.length - 1].y - 8));
      brush.fillStyle = mark.colour;
      brush.fillText(mark.label, at[at.length - 1].x + 8, at[at.length - 1].y - 8);
    }
  }

  private outlined(brush: CanvasRenderingContext2D, stroke: () => void): void {
    brush.strokeStyle = 'rgba(0, 0, 0, 0.65)';
    brush.lineWidth += 2.5;
    stroke();
    brush.lineWidth -= 2.5;
  }

  private drawDot(brush: CanvasRenderingContext2D, p: { x: number; y: number }, radius: number, colour: string): void {
    brush.beginPath();
    brush.arc(p.x, p.y, radius, 0, 2 * Math.PI);
    brush.lineWidth = 0;
    this.outlined(brush, () => brush.stroke());
    brush.fillStyle = colour;
    brush.fill();
  }

  private drawLine(brush: CanvasRenderingContext2D, at: { x: number; y: number }[], mark: Mark): void {
    brush.beginPath();
    at.forEach((p, i) => (i ? brush.lineTo(p.x, p.y) : brush.moveTo(p.x, p.y)));
    if (mark.closed) brush.closePath();
    if (mark.fill) {
      brush.fillStyle = mark.fill;
      brush.fill();
    }
    brush.lineWidth = mark.width ?? 2.5;
    brush.setLineDash(mark.dashed ? [6, 5] : []);
    this.outlined(brush, () => brush.stroke());
    brush.strokeStyle = mark.colour;
    brush.stroke();
    brush.setLineDash([]);
    if (mark.arrow && at.length > 1) this.drawArrow(brush, at, mark);
  }

  private drawArrow(brush: CanvasRenderingContext2D, at: { x: number; y: number }[], mark: Mark): void {
    const tip = at[at.length - 1], before = at[Math.max(0, at.length - 4)];
    const length = Math.hypot(tip.x - before.x, tip.y - before.y);
    if (length < 1) return;
    const ux = (tip.x - before.x) / length, uy = (tip.y - before.y) / length;
    brush.beginPath();
    brush.moveTo(tip.x + 9 * ux, tip.y + 9 * uy);
    brush.lineTo(tip.x - 3 * ux - 5 * uy, tip.y - 3 * uy + 5 * ux);
    brush.lineTo(tip.x - 3 * ux + 5 * uy, tip.y - 3 * uy - 5 * ux);
    brush.closePath();
    brush.lineWidth = 0;
    this.outlined(brush, () => brush.stroke());
    brush.fillStyle = mark.colour;
    brush.fill();
  }
}
