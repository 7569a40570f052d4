// Solids on the graphics card: the packet `solid` as textures, and the material that composes them.

import * as THREE from 'three';
import type { Json, Packet, TypedArray } from '../protocol';
import partVertex from './part.vert.glsl';
import partFragment from './part.frag.glsl';
import lappedSource from './lapped.glsl';
import lightSource from './light.glsl';

export const LAYER_WIDTH = 2048;    // as in lapped.glsl
export const PAINT_WIDTH = 1024;    // as in part.frag.glsl
const MASKS_DEEP = 32;              // masks one behind the other

/** How exemplars seen at a slant are filtered; a renderer in software has it plain. */
let anisotropy = 8;
export function setAnisotropy(most: number): void { anisotropy = most; }

/** Uniforms that all parts share: one object each, set once for all. */
export interface Shared {
  [name: string]: THREE.IUniform;
  lightDirection: { value: THREE.Vector3 };
  upDirection: { value: THREE.Vector3 };
  mode: { value: number };
  showIsolines: { value: boolean };
  showEdges: { value: boolean };
  unlit: { value: boolean };
  clip: { value: THREE.Vector4 };
  accent: { value: THREE.Vector3 };
  opacity: { value: number };
  show: { value: number };          // of parts: 0 all, 1 sections alone, 2 the skin alone, seen through
  asking: { value: number };        // of which body points are drawn instead of a picture, from 1; 0: a picture
  askedFor: { value: number };      // what of them
  known: { value: boolean };        // are there colours for each pixel?
  colours: { value: THREE.Texture | null };
}

export function sharedUniforms(): Shared {
  return {
    lightDirection: { value: new THREE.Vector3(0, 0, 1) }, upDirection: { value: new THREE.Vector3(0, 0, 1) },
    mode: { value: 0 }, showIsolines: { value: true }, showEdges: { value: false }, unlit: { value: false },
    clip: { value: new THREE.Vector4(0, 0, 0, 0) },
    accent: { value: new THREE.Vector3(0.25, 0.55, 1) }, opacity: { value: 1 }, show: { value: 0 },
    asking: { value: 0 }, askedFor: { value: 0 }, known: { value: false }, colours: { value: null },
  };
}

function settled<T extends THREE.Texture>(texture: T, filter: THREE.MagnificationTextureFilter): T {
  texture.minFilter = filter;
  texture.magFilter = filter;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

/** A flat array as a texture `width` texels wide, padded to whole rows. */
export function tableTexture(values: TypedArray, width: number, format: THREE.PixelFormat, type: THREE.TextureDataType,
                             internal: THREE.PixelFormatGPU): THREE.DataTexture {
  const channels = format === THREE.RGBAFormat || format === THREE.RGBAIntegerFormat ? 4 : 1;
  const row = width * channels, height = Math.max(1, Math.ceil(values.length / row));
  const padded = new (values.constructor as any)(row * height) as TypedArray;
  padded.set(values as any);
  const texture = new THREE.DataTexture(padded as any, width, height, format, type);
  texture.internalFormat = internal;
  return settled(texture, THREE.NearestFilter);
}

function volumeTexture(values: TypedArray, size: number[], wrapS: boolean): THREE.Data3DTexture {
  const texture = new THREE.Data3DTexture(values as any, size[0], size[1], size[2]);
  texture.format = THREE.RGBAFormat;
  texture.colorSpace = THREE.SRGBColorSpace;
  settled(texture, THREE.LinearFilter);
  texture.wrapS = texture.wrapR = THREE.RepeatWrapping;
  texture.wrapT = wrapS ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  return texture;
}

/* An exemplar of types 1 as images of r and t, one for each row of s. */
function layeredTexture(values: Uint8Array, size: number[]): THREE.DataArrayTexture {
  const [r, s, t] = size, sorted = new Uint8Array(values.length);
  for (let k = 0; k < t; ++k)
    for (let j = 0; j < s; ++j) sorted.set(values.subarray((k * s + j) * r * 4, (k * s + j + 1) * r * 4), (j * t + k) * r * 4);
  const texture = new THREE.DataArrayTexture(sorted, r, t, s);
  texture.format = THREE.RGBAFormat;
  texture.colorSpace = THREE.SRGBColorSpace;
  settled(texture, THREE.LinearFilter);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = anisotropy;
  return texture;
}

/* The masks, 48 cells each, in columns of MASKS_DEEP along z. */
function maskTexture(masks: Uint8Array, count: number, cells: number): { texture: THREE.Data3DTexture; grid: THREE.Vector3 } {
  const columns = Math.ceil(count / MASKS_DEEP), deep = Math.min(count, MASKS_DEEP);
  const values = new Uint8Array(columns * cells * cells * cells * deep);
  for (let mask = 0; mask < count; ++mask) {
    const column = Math.floor(mask / MASKS_DEEP), first = (mask % MASKS_DEEP) * cells;
    for (let t = 0; t < cells; ++t)
      for (let s = 0; s < cells; ++s) {
        const from = ((mask * cells + t) * cells + s) * cells;
        values.set(masks.subarray(from, from + cells), ((first + t) * cells + s) * cells * columns + column * cells);
      }
  }
  const texture = new THREE.Data3DTexture(values, cells * columns, cells, cells * deep);
  texture.format = THREE.RedFormat;
  return { texture: settled(texture, THREE.LinearFilter), grid: new THREE.Vector3(cells * columns, cells, cells * deep) };
}

/* Pasted exemplars in one texture: one behind the other, in columns where they would be too many. */
function pasteTextures(exemplars: { size: number[] }[], arrays: Packet['arrays']): { pastes: THREE.Data3DTexture; places: THREE.DataTexture } {
  const widest = [0, 1].map((axis) => Math.max(...exemplars.map((one) => one.size[axis])));
  const limit = 1024, places = new Float32Array(exemplars.length * 8);
  let column = 0, z = 0, deep = 0;
  exemplars.forEach(({ size }, i) => {
    if (z + size[2] > limit && z > 0) { ++column; z = 0; }
    places.set([size[0], size[1], size[2], 0, column * widest[0], 0, z, 0], i * 8);
    z += size[2];
    deep = Math.max(deep, z);
  });
  const width = widest[0] * (column + 1), values = new Uint8Array(width * widest[1] * deep * 4);
  exemplars.forEach(({ size }, i) => {
    const from = arrays[`exemplar${i + 1}`] as Uint8Array;
    for (let t = 0; t < size[2]; ++t)
      for (let s = 0; s < size[1]; ++s) {
        const line = ((places[i * 8 + 6] + t) * widest[1] + s) * width + places[i * 8 + 4];
        values.set(from.subarray((t * size[1] + s) * size[0] * 4, (t * size[1] + s + 1) * size[0] * 4), line * 4);
      }
  });
  const pastes = new THREE.Data3DTexture(values, width, widest[1], deep);
  pastes.format = THREE.RGBAFormat;
  pastes.colorSpace = THREE.SRGBColorSpace;
  const texture = new THREE.DataTexture(places, 2, exemplars.length, THREE.RGBAFormat, THREE.FloatType);
  return { pastes: settled(pastes, THREE.LinearFilter), places: settled(texture, THREE.NearestFilter) };
}

function gaussUniforms(head: Json, arrays: Packet['arrays'], size: number[], wraps: boolean): { [name: string]: THREE.IUniform } {
  const values = arrays.gauss as Float32Array, half = new Uint16Array(values.length);
  for (let i = 0; i < values.length; ++i) half[i] = THREE.DataUtils.toHalfFloat(values[i]);
  const normals = new THREE.Data3DTexture(half, size[0], size[1], size[2]);
  normals.format = THREE.RGBAFormat;
  normals.type = THREE.HalfFloatType;
  settled(normals, THREE.LinearFilter);
  normals.wrapS = normals.wrapR = THREE.RepeatWrapping;
  normals.wrapT = wraps ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
  const axes = (head.gauss.axes as number[][]).map((axis) => new THREE.Vector3(...axis));
  return {
    normals: { value: normals },
    tables: { value: tableTexture(arrays.tables, head.gauss.table, THREE.RedFormat, THREE.FloatType, 'R32F') },
    gaussMean: { value: new THREE.Vector3(...(head.gauss.mean as number[])) },
    gaussAxes: { value: axes },
    gaussReach: { value: head.gauss.reach },
  };
}

/** A body's solid as the page has it: textures, and what its shader is compiled with. */
export class BodySolid {
  readonly uniforms: { [name: string]: THREE.IUniform } = {};
  readonly defines: { [name: string]: string | number | boolean } = {};
  readonly serial: number;
  readonly head: Json;

  constructor(packet: Packet) {
    this.head = packet.head;
    this.serial = packet.head.serial;
    if (packet.head.type === 'lapped') this.makeLapped(packet);
    else this.makeGrid(packet);
  }

  private makeLapped({ head, arrays }: Packet): void {
    const own = head.exemplars[0] as { size: number[]; wraps: boolean }, further = head.exemplars.slice(1);
    const masks = maskTexture(arrays.masks as Uint8Array, head.mask_count, head.mask_size);
    Object.assign(this.uniforms, {
      patches: { value: tableTexture(arrays.patches, 1024, THREE.RGBAFormat, THREE.FloatType, 'RGBA32F') },
      masks: { value: masks.texture }, maskGrid: { value: masks.grid },
      exemplar: { value: own.wraps ? volumeTexture(arrays.exemplar0, own.size, true) : layeredTexture(arrays.exemplar0 as Uint8Array, own.size) },
    });
    if (!own.wraps) this.defines.LAYERED = 1;
    this.defines.LAPPED = 1;
    this.defines.HOMOGENEOUS = head.homogeneous ? 'true' : 'false';
    if (head.cut_count > 0) {
      this.defines.CUTS = head.cut_count;
      this.uniforms.cuts = { value: tableTexture(arrays.cuts, 4096, THREE.RedIntegerFormat, THREE.UnsignedIntType, 'R32UI') };
    }
    if (further.length > 0) {
      const { pastes, places } = pasteTextures(further, arrays);
      this.defines.PASTES = 1;
      Object.assign(this.uniforms, { pastes: { value: pastes }, pastePlaces: { value: places } });
    }
    if (head.gauss) {
      this.defines.GAUSS = 1;
      this.defines.GAUSS_TABLE = head.gauss.table;
      this.defines.GAUSS_ROWS = head.gauss.rows;
      Object.assign(this.uniforms, gaussUniforms(head, arrays, own.size, own.wraps));
    }
  }

  private makeGrid({ head, arrays }: Packet): void {
    const texture = volumeTexture(arrays.voxels, head.size, false);
    texture.wrapS = texture.wrapR = THREE.ClampToEdgeWrapping;
    texture.minFilter = THREE.LinearFilter;
    texture.generateMipmaps = false;
    const extent = (head.size as number[]).map((count, axis) => count * head.spacing[axis]);
    Object.assign(this.uniforms, {
      voxels: { value: texture }, gridOrigin: { value: new THREE.Vector3(...(head.origin as number[])) },
      gridExtent: { value: new THREE.Vector3(...extent) },
    });
    this.defines.GRID = 1;
  }

  dispose(): void {
    for (const uniform of Object.values(this.uniforms)) if (uniform.value instanceof THREE.Texture) uniform.value.dispose();
  }
}

/** The material of a body's parts. own: uniforms of this view (its layers, its paint). */
export function partMaterial(shared: Shared, solid: BodySolid | null, own: { [name: string]: THREE.IUniform },
                             defines: { [name: string]: string | number | boolean }): THREE.RawShaderMaterial {
  const lapped = solid?.defines.LAPPED ? lappedSource : '';
  const split = partFragment.indexOf('const int PAINT_WIDTH');
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: partVertex,
    fragmentShader: partFragment.slice(0, split) + lightSource + lapped + partFragment.slice(split),
    defines: { ...solid?.defines, ...defines, ...(anisotropy > 1 ? {} : { PLAIN: 1 }) },
    uniforms: { ...shared, ...solid?.uniforms, ...own },
    side: THREE.DoubleSide,
  });
}
