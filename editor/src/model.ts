// What the packets said, as far as panels and tools need it in numbers: meshes, parts, counts and exemplars. Pictures of
// them are the view's affair.

import type { Connection } from './connection';
import type { Json, Packet, PartHead, Point } from './protocol';

export interface MeshFacts {
  positions: Float32Array;          // [vertices][3]
  triangles: Uint32Array;           // [triangles][3]
  painted: Float32Array;            // [triangles], NaN without a depth
  box: [Point, Point];
  closed: boolean;
  report: Json;
}

export interface SolidFacts { type: string; patches: number; report: Json }

/** A box of voxels, sRGB and opacity. */
export interface Voxels { size: [number, number, number]; voxels: Uint8Array; wraps: boolean[] }

export interface PictureFacts { job: number; width: number; height: number; final: boolean; png: Uint8Array }

export class Model {
  meshes = new Map<number, MeshFacts>();
  solids = new Map<number, SolidFacts>();
  parts: PartHead[] = [];
  triangles = 0;
  seconds: { cut?: number; pack?: number } = {};
  /** Called for every picture that comes. */
  onPicture: ((picture: PictureFacts) => void)[] = [];

  constructor(private readonly connection: Connection) {}

  /** Takes a packet that answers no request. */
  take(packet: Packet): void {
    const { head, arrays } = packet;
    if (packet.kind === 'mesh') this.takeMesh(packet);
    else if (packet.kind === 'solid') {
      this.solids.set(head.body, { type: head.type, patches: head.patch_count ?? 0, report: head.report ?? {} });
    } else if (packet.kind === 'view') {
      this.parts = head.parts as PartHead[];
      this.seconds = head.seconds ?? {};
      this.triangles = (arrays.corners?.length ?? 0) / 3;
    } else if (packet.kind === 'picture') {
      for (const call of this.onPicture) call({ job: head.job, width: head.width, height: head.height, final: head.final,
        png: arrays.png as Uint8Array });
    }
  }

  /* A mesh whose paint alone changed comes without its shape. */
  private takeMesh({ head, arrays }: Packet): void {
    const before = this.meshes.get(head.body);
    const positions = (arrays.positions ?? before?.positions) as Float32Array | undefined;
    const triangles = (arrays.triangles ?? before?.triangles) as Uint32Array | undefined;
    if (!positions || !triangles) return;
    this.meshes.set(head.body, {
      positions, triangles, painted: arrays.painted as Float32Array, box: head.box ?? before?.box,
      closed: head.closed ?? before?.closed ?? true, report: head.report ?? before?.report ?? {},
    });
  }

  /** The diagonal of the uncut model, wherever its pieces lie now, model units; 1 as long as nothing is known. */
  diagonal(): number {
    const boxes = [...this.meshes.values()].flatMap((mesh) => (mesh.box ? [mesh.box] : []));
    if (boxes.length === 0) return 1;
    const span = [0, 1, 2].map((axis) =>
      Math.max(...boxes.map(([, high]) => high[axis])) - Math.min(...boxes.map(([low]) => low[axis])));
    return Math.hypot(...span) || 1;
  }

  /** Patches of all solids. */
  patches(): number { return [...this.solids.values()].reduce((sum, solid) => sum + solid.patches, 0); }

  /** Asks for an exemplar's voxels: of a body's solid, or of an exemplar as a document writes it. */
  async exemplar(keys: Json): Promise<Voxels> {
    const packet = await this.connection.ask<Packet>('exemplar', keys);
    return { size: packet.head.size, voxels: packet.arrays.voxels as Uint8Array, wraps: packet.head.wraps ?? [] };
  }
}
