// Fields as things to draw: a layer of depth, streamlines; and exemplars as textures.

import * as THREE from 'three';
import type { Packet } from '../protocol';
import type { ViewPart } from './parts';
import type { Shared } from './solids';

/** The palette of depths: red, yellow, green, cyan, blue from 0 to 1 (Takayama's thesis 2011, §4.4.1), sRGB. */
export function paletteColour(depth: number): THREE.Color {
  const at = 4 * Math.min(Math.max(depth, 0), 1), clamp = (x: number) => Math.min(Math.max(x, 0), 1);
  const [r, g, b] = [clamp(2 - at), clamp(Math.min(at, 4 - at)), clamp(at - 2)];
  const grey = 0.3 * r + 0.55 * g + 0.15 * b;
  const calm = (x: number) => (grey + (x - grey) * 0.86) * 0.96;
  return new THREE.Color(calm(r), calm(g), calm(b));
}

/** As CSS writes it. */
export function paletteCss(depth: number): string {
  const { r, g, b } = paletteColour(depth);
  return `rgb(${[r, g, b].map((x) => Math.round(255 * x)).join(' ')})`;
}

export function layerMesh(packet: Packet, shared: Shared): THREE.Mesh {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(packet.arrays.positions as Float32Array, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(packet.arrays.normals as Float32Array, 3));
  geometry.setIndex(new THREE.BufferAttribute(packet.arrays.triangles as Uint32Array, 1));
  const colour = paletteColour(packet.head.depth);
  const material = new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    uniforms: { lightDirection: shared.lightDirection, colour: { value: new THREE.Vector3(colour.r, colour.g, colour.b) } },
    vertexShader: 'varying vec3 vNormal; void main() { vNormal = normal; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }',
    fragmentShader: 'uniform vec3 lightDirection, colour; varying vec3 vNormal; void main() { vec3 n = normalize(vNormal) * (gl_FrontFacing ? 1.0 : -1.0);' +
                    ' float light = 0.55 + 0.45 * max(0.0, dot(n, lightDirection)) + 0.08 * n.z; gl_FragColor = vec4(colour * light, 1.0); }',
  });
  return new THREE.Mesh(geometry, material);
}

/** Streamlines as ribbons that face the eye, two pixels wide, each end coloured by its depth; lines of a part go where the
    part is. */
export function lineObject(packet: Packet, parts: ViewPart[],
                           shared: { resolution: { value: THREE.Vector2 }; pale: { value: number } }): THREE.Mesh {
  const points = packet.arrays.positions as Float32Array, start = packet.arrays.start as Uint32Array;
  const depth = packet.arrays.depth as Float32Array | undefined, part = packet.arrays.part as Uint32Array | undefined;
  const segments = Math.max(0, start[start.length - 1] - (start.length - 1));
  const ends = new Float32Array(6 * segments), colours = new Float32Array(6 * segments);
  const nowhere = new THREE.Vector3(), plain = new THREE.Color(1, 1, 1);
  let at = 0;
  for (let line = 0; line + 1 < start.length; ++line) {
    const moved = (part && parts[part[line]]?.mesh.position) || nowhere;
    for (let p = start[line]; p + 1 < start[line + 1]; ++p)
      for (let i = p; i <= p + 1; ++i, at += 3) {
        const colour = depth ? paletteColour(depth[i]) : plain;
        ends.set([points[3 * i] + moved.x, points[3 * i + 1] + moved.y, points[3 * i + 2] + moved.z], at);
        colours.set([colour.r, colour.g, colour.b], at);
      }
  }
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 1, 0]), 3));
  geometry.setIndex([0, 2, 1, 1, 2, 3]);
  const pairs = (values: Float32Array, first: string, second: string) => {
    const buffer = new THREE.InstancedInterleavedBuffer(values, 6, 1);
    geometry.setAttribute(first, new THREE.InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute(second, new THREE.InterleavedBufferAttribute(buffer, 3, 3));
  };
  pairs(ends, 'from', 'to');
  pairs(colours, 'fromColour', 'toColour');
  const material = new THREE.ShaderMaterial({ uniforms: { ...shared }, side: THREE.DoubleSide, vertexShader: ribbonVertex, fragmentShader: ribbonFragment });
  const lines = new THREE.Mesh(geometry, material);
  lines.frustumCulled = false;
  return lines;
}

// position.x: which end, position.y: which side. A little nearer to the eye than the surface they lie on.
const ribbonVertex = `
attribute vec3 from, to, fromColour, toColour;
uniform vec2 resolution;
uniform float pale;
varying vec3 colour;
void main() {
  mat4 view = projectionMatrix * modelViewMatrix;
  vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * resolution;
  vec2 side = length(along) > 1e-6 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
  gl_Position = position.x < 0.5 ? a : b;
  gl_Position.xy += side * position.y * 1.1 / resolution * 2.0 * gl_Position.w;
  gl_Position.z -= 1.5e-3 * gl_Position.w;
  colour = mix(mix(fromColour, toColour, position.x), vec3(1.0), pale);
}`;
const ribbonFragment = 'varying vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }';

/** Packet `exemplar` as a texture. */
export function exemplarTexture(packet: Packet): THREE.Data3DTexture {
  const [r, s, t] = packet.head.size as number[];
  const texture = new THREE.Data3DTexture(packet.arrays.voxels as Uint8Array<ArrayBuffer>, r, s, t);
  texture.format = THREE.RGBAFormat;
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.wrapS = texture.wrapR = texture.wrapT = THREE.RepeatWrapping;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}
