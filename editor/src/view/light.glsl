// The light of the ray tracer's pictures, for all that stands in the view.
uniform vec3 lightDirection;    // towards the key light
uniform vec3 upDirection;

vec3 fromSrgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 toSrgb(vec3 c) { return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }

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
