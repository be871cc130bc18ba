"""The window: flying through a scene, moving its lights, seeing into every stage.

`State` is what a person has chosen, `Seen` what the last frames were like. Every panel is a
function from the two to a new `State`; `controls` is one for keys and mouse. `window` runs them
and has the `Renderer` draw what the state says. Nothing in this folder draws the scene.
"""
