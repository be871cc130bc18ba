#version 330 core

uniform float strength;  // of what is behind something

in vec4 colour;
out vec4 value;

void main() {
    value = vec4(colour.rgb, colour.a * strength);
}
