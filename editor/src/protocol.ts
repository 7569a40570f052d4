// What server and page say to each other, as types; docs/protocol.md says it in words.

export type Point = [number, number, number];
/** Any JSON object: documents and operations are checked by the server, and the page reads what it needs. */
export type Json = { [key: string]: any };

export interface BodyState {
  name: string;
  type: string;                     // texture type, '' without a lapped solid
  built: { mesh: boolean; tets: boolean; fields: boolean; solid: boolean };
  shown: boolean;                   // is the solid in the view that of this document?
  why: string | null;               // why it cannot be filled yet
}

/** Why what is shown is not what the document says, a sentence; null while it is. */
export interface ViewState { why: string | null }

export interface DocumentEvent {
  event: 'document';
  revision: number;
  document: Json;
  name: string;
  undo: string[];
  redo: string[];
  saved: boolean;
  recovered: boolean;
  by: number;
  bodies: BodyState[];
  view?: ViewState;
}

export interface TypeNeeds { depth: boolean; direction: boolean; vectors: boolean; scale: boolean }

export type ValueKind = 'number' | 'colour' | 'point';
/** What a function of computed solids gives and takes; its options are in the schema. */
export interface InputFacts { name: string; takes: ValueKind | 'any'; wanted: boolean; many: boolean; standard: number }
export interface Functions { [name: string]: { gives: ValueKind; inputs: InputFacts[] } }

export interface Hello extends Omit<DocumentEvent, 'event'> {
  version: string;
  path: string;
  file: string;
  socket: number;                   // `by` of this page's own changes
  automatic: boolean;
  schema: Json;
  types: { [type: string]: TypeNeeds };
  functions: Functions;
  templates: string[];
}

export type JobStatus = 'waiting' | 'running' | 'done' | 'failed' | 'cancelled';
export interface JobEvent {
  event: 'job';
  job: number;
  what: string;
  state: JobStatus;
  fraction: number;
  text: string;
  seconds?: number;
  times?: { [stage: string]: number };
  message?: string;
  notes?: string;
}

/** Which surfaces there are: the keys of their packets, in the document's order, and why they are not what the document
    says. */
export interface SurfacesEvent {
  event: 'surfaces';
  revision: number;
  bodies: { name: string; surfaces: string[]; why: string | null }[];
}

export type ServerEvent =
  SurfacesEvent |
  DocumentEvent | JobEvent | { event: 'automatic'; on: boolean } | { event: 'note'; message: string } |
  { event: 'bodies'; revision: number; bodies: BodyState[]; view?: ViewState };

export type TypedArray = Float32Array | Uint32Array | Int16Array | Uint16Array | Int8Array | Uint8Array;
type ArrayPlace = [offset: number, type: 'f32' | 'u32' | 'i16' | 'u16' | 'i8' | 'u8', count: number];

/** A binary message, its arrays looked at in place. */
export interface Packet {
  kind: string;
  id?: number;
  head: Json;
  arrays: { [name: string]: TypedArray };
  bytes: number;
}

export interface PartHead {
  body: number;
  offset: Point;
  hidden: boolean;
  inside: Point;
  triangles: [first: number, count: number];
  vertices: [first: number, count: number];
}

const kinds = { f32: Float32Array, u32: Uint32Array, i16: Int16Array, u16: Uint16Array, i8: Int8Array, u8: Uint8Array };

/** Reads a packet; throws when it is not one. */
export function readPacket(buffer: ArrayBuffer): Packet {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as Json;
  const arrays: Packet['arrays'] = {};
  for (const [name, place] of Object.entries(head.arrays as { [name: string]: ArrayPlace })) {
    const [offset, type, count] = place;
    arrays[name] = new kinds[type](buffer, 4 + length + offset, count);
  }
  return { kind: head.kind, id: head.id, head, arrays, bytes: buffer.byteLength };
}

/** An upload: a request with arrays behind it, laid out as a packet is; bytes alone are the array `bytes`. */
export function writeUpload(request: Json, values: Uint8Array | { [name: string]: TypedArray }): ArrayBuffer {
  const given: { [name: string]: TypedArray } = values instanceof Uint8Array ? { bytes: values } : values;
  const places: { [name: string]: ArrayPlace } = {};
  let size = 0;
  for (const [name, array] of Object.entries(given)) {
    const type = (Object.keys(kinds) as (keyof typeof kinds)[]).find((word) => array instanceof kinds[word])!;
    places[name] = [size, type, array.length];
    size += 4 * Math.ceil(array.byteLength / 4);
  }
  let text = JSON.stringify({ ...request, arrays: places });
  const plain = new TextEncoder();
  text += ' '.repeat((4 - (plain.encode(text).length % 4)) % 4);
  const encoded = plain.encode(text), last = Object.values(places).at(-1);
  const end = last ? last[0] + given[Object.keys(places).at(-1)!].byteLength : 0;
  const buffer = new ArrayBuffer(4 + encoded.length + end);
  new DataView(buffer).setUint32(0, encoded.length, true);
  new Uint8Array(buffer, 4).set(encoded);
  for (const [name, array] of Object.entries(given)) {
    new Uint8Array(buffer, 4 + encoded.length + places[name][0])
      .set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
  }
  return buffer;
}
