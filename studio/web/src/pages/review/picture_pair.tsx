// A picture that a step made, before and after.
import { Picture } from '../../picture'
import { Pair, useZoom } from './pair'
import type { Mode } from './pair'
import { reviewApi } from './review_api'
import type { Version } from './review_api'
import { fileAt } from './review_model'

export function PicturePair(props: {
  path: string
  before: Version | null
  after: Version
  mode: Mode
  gain: number
}) {
  const { path, before, after } = props
  const { element, style, move } = useZoom(path)
  const picture = (version: Version, words: string) => (
    <Picture
      src={reviewApi.fileUrl(fileAt(version, path))}
      alt={`${path}, ${words}`}
      draggable={false}
      style={style}
    />
  )
  return (
    <div ref={element} class="rv-room" onPointerMove={move}>
      {before ? (
        <Pair
          mode={props.mode}
          gain={props.gain}
          before={picture(before, 'before')}
          after={picture(after, 'after')}
        />
      ) : (
        <div class="rv-pair">
          <div class="rv-layer">{picture(after, 'as it is')}</div>
        </div>
      )}
    </div>
  )
}
