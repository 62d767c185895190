from .controller_block import controller_block as controller_block
from .drive_block import drive_block as drive_block
from .joint_block import joint_block as joint_block
