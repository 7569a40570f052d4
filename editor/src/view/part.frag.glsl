// What a part of the view looks like: its solid, its depth, or clay, in the light of the ray tracer's pictures.
precision highp float;
precision highp int;
precision highp sampler2D;

in vec3 vMaterial, vWorld, vNormal, vCorner;
in float vDepth;
flat in uvec3 vInfo;
out vec4 result;

uniform vec3 cameraPosition;
uniform int mode;               // 0 the solid, 1 depth, 2 clay
uniform int show;               // 0 all, 1 sections alone, 2 the skin alone, seen through
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
in vec4 vSkin;
uniform highp sampler3D voxels;
uniform vec3 gridOrigin, gridExtent;
uniform bool known;             // are there colours for each pixel?
uniform sampler2D colours;
uniform int body, askedFor;
#endif

const int PAINT_WIDTH = 1024;

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
        if (!section && vSkin.a > 0.99) colour = fromSrgb(vSkin.rgb);
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
    bool section = (vInfo.z & 0x80000000u) != 0u;
    if (show == 1 && !section || show == 2 && (section || !gl_FrontFacing)) discard;
    if (asking > 0) {
        result = place(width);
        return;
    }
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
    float rim = 1.0 - abs(dot(normal, eye)), alpha = show == 2 ? clamp(opacity * (1.0 + 1.5 * rim * rim), 0.0, 1.0) : 1.0;
    result = vec4(toSrgb(clamp(colour, 0.0, 1.0)), alpha);
}
