// What is to stand between recorded frames when they are baked.
import { Act } from '../shoot/controls'

export function BakeChoice(props: {
  take: string
  between: string
  setBetween: (between: string) => void
  baking: boolean
  disabled: boolean
  bake: () => void
}) {
  const { between, baking } = props
  return (
    <div class="stack" style="gap:6px">
      <label for="armature-between">Baked, between recorded frames</label>
      <div class="row">
        <select
          id="armature-between"
          value={between}
          onChange={(event) => props.setBetween(event.currentTarget.value)}
        >
          <option value="hold">hard stops</option>
          <option value="linear">even pace</option>
          <option value="smooth">smooth curves</option>
          <option value="keys">keys only</option>
        </select>
        <Act disabled={baking || props.disabled} act={props.bake}>
          {baking ? 'Bakes …' : 'Bake'}
        </Act>
      </div>
      <p class="small soft">
        {between === 'keys' ? 'Keys and timeline.json, for interpolate' : 'Frames and motion.bvh'}
        , in <span class="mono">armature/{props.take}</span>
      </p>
    </div>
  )
}
