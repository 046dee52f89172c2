// The figure's colours on the page: what is chosen, what is shown, and textures as the browser has
// them.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'
import { drawnByProcessor } from '../../view/detail'
import type { Viewer } from '../../view/viewer'
import { useFrame } from '../timeline/desk'
import type { Player } from '../timeline/player'
import type { Made } from '../timeline/use_frames'
import { nextColours, shownColours } from './colours'
import type { Colours, Size } from './colours'
import { FigureColours } from './figure_colours'

/** Decoded beside the page's own work, and upside down as graphics cards want it. */
const kDecoding: ImageBitmapOptions = {
  imageOrientation: 'flipY',
  premultiplyAlpha: 'none',
  colorSpaceConversion: 'none',
}

interface Figure {
  viewer: { current: Viewer | null }
  /** the first frame is in the viewer */
  shown: boolean
  shot: string
  made: Made
  player: Player
}

/** Frames that were made anew get a figure of their own, a moment later. */
interface Kept {
  figure: FigureColours<ImageBitmap>
  made: Made
}

function useFigure(figure: Figure, line: { current: HTMLElement | null }) {
  const { viewer, shown, shot, made, player } = figure
  const { complain, version } = useStudio()
  const kept = useRef<Kept | null>(null)
  const [, drawAgain] = useState(0)
  useEffect(() => {
    if (!shown || !viewer.current) return
    const { colours, count } = made.frames
    const load = async (frame: number, size: Size) => {
      const painted = colours!.video!
      // Full size is the file itself, which nobody has to make smaller first.
      const width = size.width < painted.width ? size.width : 0
      const blob = await api.frameTexture(shot, frame, width, painted.version)
      return createImageBitmap(blob, kDecoding)
    }
    const now = new FigureColours<ImageBitmap>(viewer.current, {
      colours: colours!,
      frames: count,
      byProcessor: drawnByProcessor(),
      ownUrl: api.ownTextureUrl(shot, version),
      load,
      free: (picture) => picture.close(),
      complain,
      tell: (words) => {
        if (line.current && line.current.textContent !== words) line.current.textContent = words
      },
    })
    kept.current = { figure: now, made }
    now.show(player.frame, false)
    drawAgain((old) => old + 1)
    return () => {
      kept.current = null
      now.end()
    }
  }, [shown, shot, made, player])
  return kept
}

export function useColours(figure: Figure) {
  const { made, player, viewer } = figure
  const { complain } = useStudio()
  const [wanted, setWanted] = useState<Colours | null>(null)
  const line = useRef<HTMLParagraphElement>(null)
  const colours = made.frames.colours!
  const kept = useFigure(figure, line)
  const shown = shownColours(colours, wanted)
  const now = kept.current?.made === made ? kept.current.figure : null
  useEffect(() => {
    now?.choose(shown).catch(complain)
  }, [now, shown])
  useFrame(player, (frame) => kept.current?.figure.show(frame, player.playing))
  useEffect(() => {
    player.beforeStart = async () => {
      await kept.current?.figure.beforeStart()
      await viewer.current?.runUp(1000 / player.fps)
    }
    return player.watchState(() => kept.current?.figure.show(player.frame, player.playing))
  }, [player])
  return {
    colours,
    shown,
    choose: setWanted,
    next: () => setWanted(nextColours(colours, shown)),
    line,
  }
}
