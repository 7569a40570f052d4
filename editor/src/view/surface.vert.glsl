// A vertex of a surface that colours flow from.
precision highp float;

uniform mat4 modelMatrix, viewMatrix, projectionMatrix;

in vec3 position, normal;
in vec4 front, back;    // sRGB and opacity
in vec2 value;          // blur; 1: it is marked, as what would go

out vec3 vWorld, vNormal;
out vec4 vFront, vBack;
out vec2 vValue;

void main()
{
    vWorld = position;
    vNormal = normal;
    vFront = front;
    vBack = back;
    vValue = value;
    gl_Position = projectionMatrix * viewMatrix * modelMatrix * vec4(position, 1.0);
}
