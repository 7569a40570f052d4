// A triangle of the view, one vertex per corner. What does not change over the triangle goes through flat.
precision highp float;
precision highp int;

uniform mat4 modelMatrix, viewMatrix, projectionMatrix;

in vec3 position;       // where it is, without the part's offset
#ifdef MOVED
in vec3 material;       // where solids are asked
#endif
in vec2 normal;         // octahedral
in float depth;
#ifdef GRID
in vec4 skin;           // the skin's own colour, sRGB; opacity 0 where it is not known
out vec4 vSkin;
#endif
in uvec3 info;          // first record and number of records of layers; face of the cleaned mesh, its top bit: section

out vec3 vMaterial, vWorld, vNormal, vCorner;
out float vDepth;
flat out uvec3 vInfo;

vec3 unfold(vec2 e)
{
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}

void main()
{
    vec4 world = modelMatrix * vec4(position, 1.0);
#ifdef MOVED
    vMaterial = material;
#else
    vMaterial = position;
#endif
    vWorld = world.xyz;
    vNormal = unfold(normal);
    vDepth = depth;
    vInfo = info;
#ifdef GRID
    vSkin = skin;
#endif
    int corner = gl_VertexID % 3;
    vCorner = vec3(corner == 0, corner == 1, corner == 2);
    gl_Position = projectionMatrix * viewMatrix * world;
}
