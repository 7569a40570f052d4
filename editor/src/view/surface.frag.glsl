// What a surface that colours flow from looks like: the colour of the side that is turned to the eye.
precision highp float;
precision highp int;

in vec3 vWorld, vNormal;
in vec4 vFront, vBack;
in vec2 vValue;
out vec4 result;

uniform vec3 cameraPosition, accent;
uniform vec4 clip;              // clip plane; zero normal: none
uniform bool chosen, showBlur;
uniform int hidden;             // the side behind which it is hollow: 0 none, 1 front, 2 back
uniform float opacity, mostBlur;
uniform bool through;           // drawn where it is seen through: its near side alone

LIGHT
void main()
{
    if (dot(vWorld, clip.xyz) > clip.w && clip.xyz != vec3(0.0)) discard;
    if (through && !gl_FrontFacing) discard;
    vec3 eye = normalize(cameraPosition - vWorld);
    vec3 normal = normalize(vNormal) * (gl_FrontFacing ? 1.0 : -1.0);
    bool front = hidden == 0 ? gl_FrontFacing : hidden == 2; // the hollow side shows the other's colour
    vec3 colour = fromSrgb(front ? vFront.rgb : vBack.rgb);
    if (showBlur) colour = mix(vec3(0.12), vec3(1.0, 0.45, 0.08), mostBlur > 0.0 ? clamp(vValue.x / mostBlur, 0.0, 1.0) : 0.0);
    colour = mix(colour, vec3(0.9, 0.1, 0.15), 0.75 * vValue.y);
    colour = lit(colour, normal, eye, true);
    if (hidden == (gl_FrontFacing ? 1 : 2)) colour *= 0.55;
    float rim = 1.0 - abs(dot(normal, eye));
    if (chosen) colour = mix(colour, accent, 0.5 * pow(rim, 3.0));
    float alpha = through ? clamp(opacity * (1.0 + 1.5 * rim * rim), 0.0, 1.0) : 1.0; // rims are denser
    result = vec4(toSrgb(clamp(colour, 0.0, 1.0)), alpha);
}
