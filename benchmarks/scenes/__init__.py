"""The scenes on which programs are compared, each stated once."""

from benchmarks.scenes import corner_plate, end_shear, free_ruler, hemisphere, hinged_roof, l_shape, paper_example, roll_up
from benchmarks.scenes.scene import Quantity, Scene

SCENES: dict[str, Scene] = {
    scene.name: scene
    for scene in (
        end_shear.SCENE, roll_up.SCENE, hemisphere.SCENE, hinged_roof.SCENE, l_shape.SCENE, corner_plate.SCENE,
        *paper_example.SCENES, free_ruler.SCENE,
    )
}  # fmt: skip

__all__ = ["SCENES", "Quantity", "Scene"]
