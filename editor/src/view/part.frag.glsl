// What a part of the view looks like: its solid, its depth, or clay, in the light of the ray tracer's pictures.
precision highp float;
precision highp int;
precision highp sampler2D;

in vec3 vMaterial, vWorld, vNormal, vCorner;
in float vDepth;
flat in uvec3 vInfo;
out vec4 result;

uniform vec3 cameraPosition;
uniform vec3 lightDirection;    // towards the key light
uniform vec3 upDirection;
uniform int mode;               // 0 the solid, 1 depth, 2 clay
uniform bool hasDepth, hasPaint, showIsolines, showEdges, picked, stale, unlit;
uniform float opacity;
uniform sampler2D painted;      // depth painted on each face, PAINT_WIDTH in a row; negative: none
uniform vec4 clip;              // clip plane in material coordinates; zero normal: none
uniform vec3 accent;
uniform int asking;             // a body, from 1: where its points are is drawn, not how they look
#ifdef GHOST
uniform mat4 ghostMatrix;       // material coordinates to texture coordinates
uniform highp sampler3D ghost;
uniform vec2 ghostMask;         // radius, drop-off
#endif
#ifdef GRID
uniform highp sampler3D voxels;
uniform vec3 gridOrigin, gridExtent;
uniform bool known;             // are there colours for each pixel?
uniform sampler2D colours;
uniform int body, askedFor;
#endif

const int PAINT_WIDTH = 1024;

vec3 fromSrgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 toSrgb(vec3 c) { return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }

/* Red, yellow, green, cyan, blue from depth 0 to 1 (Takayama's thesis 2011, §4.4.1), a little calmer than pure. */
vec3 palette(float depth)
{
    float at = 4.0 * clamp(depth, 0.0, 1.0);
    vec3 colour = vec3(clamp(2.0 - at, 0.0, 1.0), clamp(min(at, 4.0 - at), 0.0, 1.0), clamp(at - 2.0, 0.0, 1.0));
    return fromSrgb(mix(vec3(dot(colour, vec3(0.3, 0.55, 0.15))), colour, 0.86) * 0.96);
}

float line(float value, float width)
{
    float slope = fwidth(value);
    return slope > 0.0 ? 1.0 - clamp(abs(fract(value - 0.5) - 0.5) / slope - width + 0.5, 0.0, 1.0) : 0.0;
}

#ifdef GHOST
vec4 ghostColour(vec3 point)
{
    vec3 rst = (ghostMatrix * vec4(point, 1.0)).xyz;
    if (any(lessThan(rst, vec3(0.0))) || any(greaterThan(rst, vec3(1.0)))) return vec4(0.0);
    vec3 off = rst - 0.5, squares = off * off;
    float inside = ghostMask.x - sqrt(sqrt(dot(squares, squares)));
    float alpha = smoothstep(0.0, 1.0, ghostMask.y > 0.0 ? inside / ghostMask.y : step(0.0, inside));
    vec4 colour = textureLod(ghost, rst, 0.0);
    return vec4(colour.rgb, colour.a * alpha);
}
#endif

vec3 ownColour(bool section, uint face)
{
    if (mode == 0) {
        vec3 colour = vec3(0.62, 0.6, 0.57);
#ifdef LAPPED
        colour = vInfo.y > 0u ? lappedColour(vInfo.xy, vCorner, vDepth).rgb : colour;
#endif
#ifdef GRID
        colour = textureLod(voxels, (vMaterial - gridOrigin) / gridExtent, 0.0).rgb;
        vec4 own = known ? texelFetch(colours, ivec2(gl_FragCoord.xy), 0) : vec4(0.0);
        if (own.a > 0.0) colour = fromSrgb(own.rgb);
#endif
#ifdef GHOST
        vec4 over = ghostColour(vMaterial);
        colour = mix(colour, over.rgb, over.a);
#endif
        return colour;
    }
    vec3 colour = section ? vec3(0.55, 0.5, 0.46) : vec3(0.6, 0.59, 0.57);
    if (mode == 1 && hasDepth) {
        colour = palette(vDepth);
        if (showIsolines) colour *= 1.0 - 0.55 * line(vDepth * 20.0, 0.6) * (line(vDepth * 4.0, 3.0) > 0.0 ? 1.0 : 0.55);
    }
    if (!section && hasPaint) {
        float depth = texelFetch(painted, ivec2(int(face) % PAINT_WIDTH, int(face) / PAINT_WIDTH), 0).r;
        if (depth >= 0.0) colour = palette(depth);
        else if (mode == 1 && hasDepth) colour = mix(colour, vec3(dot(colour, vec3(0.3, 0.59, 0.11))), 0.45);
    }
    return colour;
}

vec3 lit(vec3 colour, vec3 normal, vec3 eye, bool section)
{
    const float wrap = 0.22, ambient = 0.42, strength = 0.8;
    float facing = dot(normal, lightDirection);
    float key = max(0.0, facing + wrap) / (1.0 + wrap);
    float sky = 0.72 + 0.28 * dot(normal, upDirection);
    vec3 lit = colour * (strength * key + ambient * sky);
    vec3 middle = normalize(lightDirection + eye);
    float fresnel = 0.05 + 0.95 * pow(1.0 - max(0.0, dot(eye, middle)), 5.0);
    float shine = fresnel * (90.0 + 8.0) / 25.13 * pow(max(0.0, dot(normal, middle)), 90.0) * max(0.0, facing);
    lit += strength * (section ? 0.5 : 0.2) * shine;
    return mix(lit, 0.8 + 0.2 * (1.0 - exp(-(lit - 0.8) / 0.2)), step(0.8, lit)); // highlights bend to stay below 1
}

/* The point that is seen and how wide a pixel is there, its normal, or the way to the eye; all 0 of other bodies. */
vec4 place(float width)
{
#ifdef GRID
    vec3 eye = normalize(cameraPosition - vWorld);
    if (asking != body + 1 || !gl_FrontFacing) return vec4(0.0);
    return askedFor == 0 ? vec4(vMaterial, max(width, 1e-9)) : askedFor == 1 ? vec4(normalize(vNormal), 1.0) : vec4(eye, 1.0);
#else
    return vec4(0.0);
#endif
}

void main()
{
    float width = max(length(dFdx(vMaterial)), length(dFdy(vMaterial)));
    if (dot(vMaterial, clip.xyz) > clip.w && clip.xyz != vec3(0.0)) discard;
    if (asking > 0) {
        result = place(width);
        return;
    }
    bool section = (vInfo.z & 0x80000000u) != 0u;
    uint face = vInfo.z & 0x7fffffffu;
    vec3 eye = normalize(cameraPosition - vWorld);
    vec3 normal = normalize(vNormal);
#ifdef FACETED
    normal = normalize(cross(dFdx(vWorld), dFdy(vWorld)));
#endif
    vec3 colour = ownColour(section, face);
    if (stale && mode == 0) colour = mix(colour, vec3(dot(colour, vec3(0.3, 0.59, 0.11))), 0.35);
    if (!gl_FrontFacing) colour = vec3(0.2, 0.16, 0.14); // never seen of a closed part, but where it is clipped
    else if (!unlit) colour = lit(colour, normal, eye, section);
    if (showEdges) {
        vec3 edge = vCorner / max(fwidth(vCorner), 1e-6);
        colour *= mix(0.72, 1.0, smoothstep(0.6, 1.4, min(edge.x, min(edge.y, edge.z))));
    }
    if (picked) colour = mix(colour, accent, 0.08 + 0.5 * pow(1.0 - max(0.0, dot(normal, eye)), 3.0));
    result = vec4(toSrgb(clamp(colour, 0.0, 1.0)), opacity);
}
