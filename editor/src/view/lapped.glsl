// The colour of a lapped solid at a point of a triangle, composed from the patches listed for it: the rule stands in
// pith/solid.h at pith_lapped_layers, and src/solid/lapped_sample.c is its other half. Texture coordinates are mixed from
// the triangle's corners (Takayama et al. 2008, §5.1); what differs from the paper: one pass that goes through the list
// from the topmost patch and stops at the first that hides all below, instead of a blended triangle for each.
precision highp sampler3D;
precision highp usampler2D;

uniform usampler2D layers;      // records of four words, LAYER_WIDTH in a row
uniform sampler2D patches;      // offsets along r, s, t; mask + 1024 * exemplar
uniform sampler3D masks;        // 48 cells a mask, one behind the other, 32 to a column
#ifdef LAYERED
uniform highp sampler2DArray exemplar;  // an image of r and t for each row of s
#else
uniform sampler3D exemplar;
#endif
uniform ivec3 maskGrid;         // cells of the whole texture
uniform float rtUnit, sUnit;
#ifdef CUTS
uniform usampler2D cuts;        // bits of 32³ cells a patch, four patches in a row
#endif
#ifdef PASTES
uniform sampler3D pastes;       // exemplars set by hand, packed
uniform sampler2D pastePlaces;  // two texels each: size; where it begins, in voxels
#endif
#ifdef GAUSS
uniform sampler3D normals;      // the exemplar as normal variables
uniform sampler2D tables;       // the way back: [row * 4 + channel][GAUSS_TABLE]
uniform vec3 gaussMean, gaussAxes[3];
uniform float gaussReach;
#endif

const int LAYER_WIDTH = 2048;
const int MASK = 48;

vec3 low16(uvec3 w) { return vec3(ivec3(w << 16u) >> 16); }
vec3 high16(uvec3 w) { return vec3(ivec3(w) >> 16); }
uvec4 record(int i) { return texelFetch(layers, ivec2(i % LAYER_WIDTH, i / LAYER_WIDTH), 0); }

float maskAlpha(int mask, vec3 rst)
{
    if (!(rst.x > 0.0 && rst.x < 1.0 && rst.z > 0.0 && rst.z < 1.0)) return 0.0;
    vec3 cell = clamp(vec3(rst.x, clamp(rst.y, 0.0, 1.0), rst.z) * float(MASK), 0.5, float(MASK) - 0.5);
    cell += vec3(mask / 32, 0, mask % 32) * float(MASK);
    return textureLod(masks, cell / vec3(maskGrid), 0.0).r;
}

#ifdef CUTS
float cutAlpha(int patchNumber, vec3 rst)
{
    if (!(rst.x > 0.0 && rst.x < 1.0 && rst.z > 0.0 && rst.z < 1.0)) return 0.0;
    vec3 at = clamp(rst * 32.0 - 0.5, 0.0, 31.0);
    ivec3 cell = min(ivec3(at), 30);
    vec3 part = at - vec3(cell);
    int column = (patchNumber & 3) * 1024, row = patchNumber >> 2;
    vec4 sides;     // (s, t), (s+1, t), (s, t+1), (s+1, t+1), mixed along r
    for (int i = 0; i < 4; ++i) {
        int line = column + (cell.z + (i >> 1)) * 32 + cell.y + (i & 1);
        uint bits = texelFetch(cuts, ivec2(line, row), 0).r >> uint(cell.x);
        sides[i] = mix(float(bits & 1u), float((bits >> 1) & 1u), part.x);
    }
    return clamp(2.0 * mix(mix(sides.x, sides.y, part.y), mix(sides.z, sides.w, part.y), part.z) - 0.5, 0.0, 1.0);
}
#endif

/* One patch at this point. gradients: of its texture coordinates over the screen, for a filtered lookup. */
struct Layer { vec3 rst, dx, dy; vec4 about; int number; float fade; bool spare, whole; };

Layer layerAt(inout int i, vec3 corner, vec3 dx, vec3 dy, float depth, vec2 slope)
{
    Layer layer;
    uvec4 words = record(i++);
    vec3 r = low16(words.xyz) * rtUnit, t = high16(words.xyz) * rtUnit;
    layer.rst = vec3(dot(r, corner), depth, dot(t, corner));
    layer.dx = vec3(dot(r, dx), slope.x, dot(t, dx));
    layer.dy = vec3(dot(r, dy), slope.y, dot(t, dy));
    layer.fade = 1.0;
    if ((words.w & 0x80000000u) != 0u) {
        uvec4 more = record(i++);
        vec3 s = vec3(int(more.x << 16u) >> 16, int(more.x) >> 16, int(more.y << 16u) >> 16) * sUnit;
        vec3 fade = vec3(more.y >> 16u, more.z & 0xffffu, more.z >> 16u) / 65535.0;
        layer.rst.y = dot(s, corner);
        layer.dx.y = dot(s, dx);
        layer.dy.y = dot(s, dy);
        layer.fade = clamp(3.0 * dot(fade, corner) - 1.0, 0.0, 1.0);
    }
    layer.spare = (words.w & 0x01000000u) != 0u;
    layer.whole = (words.w & 0x02000000u) != 0u;
    layer.number = int(words.w & 0xffffffu);
    ivec2 size = textureSize(patches, 0);
    layer.about = texelFetch(patches, ivec2(layer.number % size.x, layer.number / size.x), 0);
    return layer;
}

#ifdef LAYERED
vec4 filtered(vec3 at, vec2 dx, vec2 dy)
{
#ifdef PLAIN
    vec2 size = vec2(textureSize(exemplar, 0).xy);
    return textureLod(exemplar, at, 0.5 * log2(max(dot(dx * size, dx * size), dot(dy * size, dy * size))));
#else
    return textureGrad(exemplar, at, dx, dy);
#endif
}

/* Types 1 are filtered over r and t alone: a skin two voxels thick must not take the colour of the flesh under it because
   it is seen from afar. Along s a few rows are looked at, as many as the pixel spans. */
vec4 exemplarAt(Layer layer)
{
    vec3 at = layer.rst + layer.about.xyz;
    float rows = float(textureSize(exemplar, 0).z), span = max(abs(layer.dx.y), abs(layer.dy.y)) * rows;
    int taps = int(clamp(ceil(span), 1.0, 4.0));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < taps; ++i) {
        float row = clamp(at.y * rows - 0.5 + ((float(i) + 0.5) / float(taps) - 0.5) * span * float(taps > 1), 0.0, rows - 1.0);
        float low = floor(row);
        vec4 a = filtered(vec3(at.xz, low), layer.dx.xz, layer.dy.xz), b = filtered(vec3(at.xz, low + 1.0), layer.dx.xz, layer.dy.xz);
        sum += mix(a, b, row - low);
    }
    return sum / float(taps);
}
#else
vec4 exemplarAt(Layer layer)
{
#ifdef PLAIN
    vec3 size = vec3(textureSize(exemplar, 0)), dx = layer.dx * size, dy = layer.dy * size;
    return textureLod(exemplar, layer.rst + layer.about.xyz, 0.5 * log2(max(dot(dx, dx), dot(dy, dy))));
#else
    return textureGrad(exemplar, layer.rst + layer.about.xyz, layer.dx, layer.dy);
#endif
}
#endif

#ifdef PASTES
vec4 pasteAt(Layer layer, int which)
{
    vec3 size = texelFetch(pastePlaces, ivec2(0, which), 0).xyz, first = texelFetch(pastePlaces, ivec2(1, which), 0).xyz;
    vec3 voxel = clamp(layer.rst * size, vec3(0.5), size - 0.5);
    return textureLod(pastes, (first + voxel) / vec3(textureSize(pastes, 0)), 0.0);
}
#endif

#ifdef GAUSS
float fromTable(int row, int channel, float g)
{
    float at = clamp((g / gaussReach + 1.0) * (0.5 * float(GAUSS_TABLE - 1)), 0.0, float(GAUSS_TABLE - 1));
    int i = min(int(at), GAUSS_TABLE - 2), line = row * 4 + channel;
    float a = texelFetch(tables, ivec2(i, line), 0).r, b = texelFetch(tables, ivec2(i + 1, line), 0).r;
    return mix(a, b, at - float(i));
}

vec4 fromNormal(vec4 value, float s)
{
    float at = clamp(s * float(GAUSS_ROWS) - 0.5, 0.0, float(GAUSS_ROWS - 1));
    int low = GAUSS_ROWS > 1 ? int(at) : 0, high = min(low + 1, GAUSS_ROWS - 1);
    vec4 mixed;
    for (int c = 0; c < 4; ++c) mixed[c] = mix(fromTable(low, c, value[c]), fromTable(high, c, value[c]), at - float(low));
    vec3 colour = gaussMean + gaussAxes[0] * mixed.x + gaussAxes[1] * mixed.y + gaussAxes[2] * mixed.z;
    return vec4(max(colour, 0.0), mixed.w);
}
#endif

/* Linear colour and opacity. records: first and number. corner: weights of the triangle's corners here. */
vec4 lappedColour(uvec2 records, vec3 corner, float depth)
{
    vec3 dx = dFdx(corner), dy = dFdy(corner);
    vec2 slope = vec2(dFdx(depth), dFdy(depth));
    float through = 1.0, weight = 0.0, nearest = 1e9;
    vec4 sum = vec4(0.0), spare = vec4(0.0);
#ifdef GAUSS
    vec4 blended = vec4(0.0);
    float blendedWeight = 0.0, squares = 0.0;
#endif
    int i = int(records.x), end = int(records.x + records.y);
    for (int guard = 0; guard < 512 && i < end && through > 0.004; ++guard) {
        Layer layer = layerAt(i, corner, dx, dy, depth, slope);
        int mask = int(layer.about.w) & 1023, which = int(layer.about.w) >> 10;
        float alpha = layer.whole ? 1.0 : 0.0;
        if (!layer.spare && !layer.whole) {
#ifdef CUTS
            alpha = layer.number < CUTS ? cutAlpha(layer.number, layer.rst) : maskAlpha(mask, layer.rst);
#else
            alpha = maskAlpha(mask, layer.rst);
#endif
            alpha *= layer.fade;
        }
#ifdef PASTES
        if (which > 0) {
            if (!(alpha > 0.0 && layer.rst.y > 0.0 && layer.rst.y < 1.0)) continue;
            vec4 colour = pasteAt(layer, which - 1);
            float factor = alpha * colour.a * through;
            sum += factor * vec4(colour.rgb, 1.0);
            weight += factor;
            through -= factor;
            continue;
        }
#endif
        if (!(alpha > 0.0)) {   // remembered for points that nothing covers
            if (weight > 0.0) continue;
            vec3 off = abs(layer.rst - 0.5);
            float distance = HOMOGENEOUS ? max(max(off.x, off.z), off.y) : max(off.x, off.z);
            if (distance < nearest) nearest = distance, spare = exemplarAt(layer);
            continue;
        }
        float factor = alpha * through;
#ifdef GAUSS
        blended += factor * textureLod(normals, layer.rst + layer.about.xyz, 0.0);
        blendedWeight += factor;
        squares += factor * factor;
#else
        sum += factor * exemplarAt(layer);
        weight += factor;
#endif
        through -= factor;
    }
#ifdef GAUSS
    if (blendedWeight > 0.0) {
        sum += blendedWeight * fromNormal(blended / sqrt(squares), depth);
        weight += blendedWeight;
    }
#endif
    return weight > 0.0 ? sum / weight : spare;
}
