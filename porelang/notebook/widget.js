// Made by `make page` from editors/page, a5e62f2125c2429ef26effb8c974d50ceb978fb025d5441c6245924542cc3b30. All of it is porelang's.
var k=Math.PI/180,y={iso:[-45,Math.atan(Math.SQRT1_2)/k],front:[-90,0],back:[90,0],left:[180,0],right:[0,0],top:[-90,90],bottom:[-90,-90]},M=Math.tan(11*k),K=1.06,O=(a,t)=>a[0]*t[0]+a[1]*t[1]+a[2]*t[2],V=(a,t)=>[a[1]*t[2]-a[2]*t[1],a[2]*t[0]-a[0]*t[2],a[0]*t[1]-a[1]*t[0]],L=(a,t,e)=>[a[0]+e*t[0],a[1]+e*t[1],a[2]+e*t[2]],T=class{constructor(){[this.azimuth,this.elevation]=y.iso,this.target=[0,0,0],this.height=100,this.perspective=!0}axes(){let t=this.azimuth*k,e=this.elevation*k,i=[Math.cos(t)*Math.cos(e),Math.sin(t)*Math.cos(e),Math.sin(e)],n=[-Math.sin(t),Math.cos(t),0];return{out:i,right:n,up:V(i,n)}}turn(t,e){this.azimuth=(this.azimuth+t)%360,this.elevation=Math.min(90,Math.max(-90,this.elevation+e))}move(t,e,i){let{right:n,up:s}=this.axes(),o=this.height/i;this.target=L(L(this.target,n,-t*o),s,e*o)}closer(t){this.height=Math.min(1e7,Math.max(1e-4,this.height/t))}fit(t,e,i){let{out:n,right:s,up:o}=this.axes();this.target=t.map((h,p)=>(h+e[p])/2);let r=0,l=0;for(let h=0;h<8;h++){let p=t.map((u,f)=>(h>>f&1?e[f]:u)-this.target[f]),c=K*Math.max(Math.abs(O(p,s))/i,Math.abs(O(p,o)));l=Math.max(l,c),r=Math.max(r,c/M+O(p,n))}this.height=this.perspective?2*M*r:2*l}uniforms(t){let{out:e,right:i,up:n}=this.axes(),s=this.perspective?this.height/2/M:2*t;return{eye:L(this.target,e,s),camera:[...i,...n,-e[0],-e[1],-e[2]],zoom:this.perspective?M:this.height/2,perspective:this.perspective?1:0}}};var E=a=>String(Number(Number(a).toPrecision(6)));function g(a,t={},...e){let i=Object.assign(document.createElement(a),t);return i.append(...e),i}function Y(a){let t=10**Math.floor(Math.log10(a/250));return t*[5,2,1].find(e=>e*t<=a/250)}function P(a,t){let e=`param-${a.name}`,i=g("div",{className:"name"},g("label",{textContent:a.name,htmlFor:e})),n=g("div",{className:"param"},i);a.doc&&n.append(g("div",{className:"doc",id:`${e}-doc`,textContent:a.doc}));let s;if(a.choices.length)s=g("select",{},...a.choices.map(o=>new Option(String(o)))),n.put=o=>{s.value=String(o)},s.onchange=()=>t(a.name,a.choices[s.selectedIndex]);else{let[o,r,l]=[a.low,a.high,a.step].map(c=>c===null?null:c/a.scale);s=g("input",{type:"range"});let h=g("input",{type:"number"});h.setAttribute("aria-label",`${a.name}${a.unit?` in ${a.unit}`:""}`);for(let c of[s,h])Object.assign(c,{min:o,max:r,step:c===s?l??Y(r-o):"any"});n.put=c=>{s.value=c/a.scale,h.getRootNode().activeElement!==h&&(h.value=E(c/a.scale))};let p=c=>{let u=Math.min(Math.max(c,o),r);h.value=E(u),t(a.name,Math.min(Math.max(u*a.scale,a.low),a.high))};s.oninput=()=>p(Number(s.value)),h.onchange=()=>{h.value===""&&(h.value=s.value),s.value=h.value,p(Number(h.value))},s.title="Double click: its default",s.ondblclick=()=>{s.value=a.default/a.scale,p(a.default/a.scale)},i.append(g("div",{className:"box"},h,a.unit))}return s.id=e,a.doc&&s.setAttribute("aria-describedby",`${e}-doc`),n.append(s),n.put(a.value),n}function I(a,t,e,i){return a.map((n,s)=>{let o=g("input",{type:"checkbox",id:`output-${s}`,checked:t.includes(n)});o.onchange=()=>{let l=a.filter(h=>h===n?o.checked:t.includes(h));l.length?i(l):o.checked=!0};let r=g("span",{className:"swatch"});return e.has(n)&&(r.style.background=`rgb(${e.get(n).map(l=>Math.round(255*l)).join(" ")})`),g("label",{htmlFor:o.id},o,r,n)})}function D(a,t){if(a.hidden=!t,!t)return;let[e,i,n]=t.ends,s=g("canvas",{width:1,height:256}),o=s.getContext("2d"),r=c=>{let u=8*(c<i?.5*(c-e)/(i-e):.5+.5*(c-i)/(n-i)),f=Math.min(7,Math.max(0,Math.floor(u)));return t.colours[f].map((m,d)=>Math.round(255*(m+(u-f)*(t.colours[f+1][d]-m))))};for(let c=0;c<256;c++)o.fillStyle=`rgb(${r(n+(e-n)*c/255).join(" ")})`,o.fillRect(0,c,1,1);let h=[...new Set([e,...t.numbers,n])].filter(c=>c===e||c===n||Math.min(c-e,n-c)>.07*(n-e)).map(c=>{let u=g("span",{className:"tick",textContent:E(c.toPrecision(4))});return u.style.top=`${100*(n-c)/(n-e)}%`,u}),p=`${t.shown}${t.unit&&t.unit!==t.shown?` (${t.unit.replace(t.shown,"").trim()||t.unit})`:""}`;a.setAttribute("aria-label",`Colours of ${p}: from ${E(e)} to ${E(n)}`),a.replaceChildren(g("div",{className:"what",textContent:p}),g("div",{className:"scale"},s,...h))}function $(a,t={}){let{canvas:e,camera:i}=a,n=new Map;e.addEventListener("contextmenu",s=>s.preventDefault()),e.addEventListener("pointerdown",s=>{e.setPointerCapture(s.pointerId),n.set(s.pointerId,{x:s.clientX,y:s.clientY,moves:s.button!==0||s.shiftKey,cuts:s.altKey})}),e.addEventListener("pointermove",s=>{let o=n.get(s.pointerId);if(!o)return;let r=s.clientX-o.x,l=s.clientY-o.y;if(n.size===2){let[h]=[...n].filter(([u])=>u!==s.pointerId).map(([,u])=>u),p=Math.hypot(o.x-h.x,o.y-h.y),c=Math.hypot(s.clientX-h.x,s.clientY-h.y);p>0&&c>0&&i.closer(c/p),i.move(r/2,l/2,e.clientHeight)}else o.cuts?a.slide(r,l):o.moves?i.move(r,l,e.clientHeight):i.turn(-.4*r,.4*l);o.x=s.clientX,o.y=s.clientY,a.moved()});for(let s of["pointerup","pointercancel"])e.addEventListener(s,o=>n.delete(o.pointerId));e.addEventListener("wheel",s=>{s.preventDefault(),i.closer(Math.exp(-s.deltaY*(s.deltaMode===1?.04:.0015))),a.moved()},{passive:!1}),e.addEventListener("keydown",s=>{if(s.ctrlKey||s.metaKey)return;let o=s.shiftKey?1:5,r=s.altKey?{ArrowLeft:()=>a.step(-1),ArrowDown:()=>a.step(-1),ArrowRight:()=>a.step(1),ArrowUp:()=>a.step(1)}:{ArrowLeft:()=>i.turn(-o,0),ArrowRight:()=>i.turn(o,0),ArrowUp:()=>i.turn(0,o),ArrowDown:()=>i.turn(0,-o),"+":()=>i.closer(1.15),"=":()=>i.closer(1.15),"-":()=>i.closer(1/1.15),f:()=>a.fit(),o:()=>a.project(),...t};s.altKey||Object.keys(y).forEach((h,p)=>{r[p+1]=()=>a.stand(h)});let l=r[s.key]??r[s.key.toLowerCase()];l&&(s.preventDefault(),s.stopPropagation(),l(),a.moved())})}var Q=`#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;var S=class{constructor(t,e,i){this.canvas=t,this.camera=e,this.told=i,this.scene=null,this.section={axis:-1,offset:0,keeps:1},this.coarse=4,this.perPixel=0,this.drawn=0,this.refines=!0,this.start(),this.losses=0,t.addEventListener("webglcontextlost",n=>{n.preventDefault(),this.losses+=1,this.scene=null}),t.addEventListener("webglcontextrestored",()=>{if(this.start(),this.losses>3)return this.ready?.("This browser's graphics give up on the part: it takes them too long. `pore render` draws it.");this.wanted&&this.take(this.wanted,this.ready)})}start(){let t=this.canvas.getContext("webgl2",{antialias:!1,preserveDrawingBuffer:!0,alpha:!0,premultipliedAlpha:!0,depth:!0});if(!t)throw new Error("This browser has no WebGL 2 here, with which the part is drawn. `pore render` draws without it.");this.gl=t,this.parallel=t.getExtension("KHR_parallel_shader_compile"),this.programs=new Map,this.textures=[]}end(){clearTimeout(this.still),this.scene=this.wanted=null,this.wish=null,this.gl.getExtension("WEBGL_lose_context")?.loseContext()}take(t,e){let i=this.gl;if(i.isContextLost()){this.wanted=t,this.ready=e;return}let n=[...t.bodies,...t.plane?[t.plane]:[]],s=n.map(r=>this.compiled(r.text));this.wanted=t,this.ready=e;let o=()=>{if(!(this.wanted!==t||i.isContextLost())){if(this.parallel&&s.some(r=>!i.getProgramParameter(r.program,this.parallel.COMPLETION_STATUS_KHR)))return setTimeout(o,20);for(let r of s){if(i.getProgramParameter(r.program,i.LINK_STATUS))continue;let l=r.shaders.map(h=>i.getShaderInfoLog(h)).concat(i.getProgramInfoLog(r.program)).filter(Boolean).join(`
`);return e(`This browser's graphics driver refuses the shader of the part:
${l}`)}for(let[r,l]of this.programs)s.includes(l)||(i.deleteProgram(l.program),this.programs.delete(r));n.some(r=>!this.scene||![...this.scene.bodies,this.scene.plane].some(l=>l?.text===r.text))&&(this.coarse=8*(1+this.losses)),this.scene=t,this.load(n),e(""),this.moved()}};o()}compiled(t){if(this.programs.has(t))return this.programs.get(t);performance.mark("compiled");let e=this.gl,i=e.createProgram(),n=[[e.VERTEX_SHADER,Q],[e.FRAGMENT_SHADER,t]].map(([o,r])=>{let l=e.createShader(o);return e.shaderSource(l,r),e.compileShader(l),e.attachShader(i,l),l});e.linkProgram(i);let s={program:i,shaders:n,places:new Map};return this.programs.set(t,s),s}load(t){let e=this.gl;for(let n of this.textures)e.deleteTexture(n);this.textures=[];let i=n=>{let s=e.createTexture();e.activeTexture(e.TEXTURE0),e.bindTexture(n,s);for(let o of[e.TEXTURE_WRAP_S,e.TEXTURE_WRAP_T])e.texParameteri(n,o,e.CLAMP_TO_EDGE);for(let o of[e.TEXTURE_MIN_FILTER,e.TEXTURE_MAG_FILTER])e.texParameteri(n,o,e.NEAREST);return this.textures.push(s),s};e.pixelStorei(e.UNPACK_ALIGNMENT,4);for(let n of t)n.units=[],n.cells&&(n.units.push([e.TEXTURE_3D,i(e.TEXTURE_3D),"cells"]),e.texImage3D(e.TEXTURE_3D,0,e.R32F,...n.counts,0,e.RED,e.FLOAT,n.cells)),n.data.forEach((s,o)=>{n.units.push([e.TEXTURE_2D,i(e.TEXTURE_2D),`data${o}`]);let r=Math.ceil(s.length/2048),l=new Uint32Array(r*2048);l.set(s),e.texImage2D(e.TEXTURE_2D,0,e.R32UI,2048,r,0,e.RED_INTEGER,e.UNSIGNED_INT,l)})}moved(){this.wish=(this.wish??0)+1,clearTimeout(this.still),!this.asked&&(this.asked=!0,requestAnimationFrame(()=>{if(this.asked=!1,!this.scene)return;this.quick();let t=this.wish;this.still=setTimeout(()=>this.full(t),150)}))}size(t){let e=Math.min(window.devicePixelRatio||1,2)/t;return[Math.max(1,Math.round(this.canvas.clientWidth*e)),Math.max(1,Math.round(this.canvas.clientHeight*e))]}quick(){let t=this.size(this.coarse);[this.canvas.width,this.canvas.height]=t;let e=performance.now();this.strip(t,0,t[1],1),this.wait(0);let i=performance.now()-e;this.perPixel=i/(t[0]*t[1]),this.told(`${t[0]} x ${t[1]}, ${i.toFixed(1)} ms`),i>40&&this.coarse<8?this.coarse=Math.min(8,this.coarse*Math.sqrt(i/40)):i<40/3&&(this.coarse=Math.max(1,this.coarse/1.3))}wait(t){this.gl.readPixels(0,t,1,1,this.gl.RGBA,this.gl.UNSIGNED_BYTE,new Uint8Array(4))}full(t,e=1){let i=this.gl,n=this.size(1),s=n.map(m=>m*e),o=Math.max(1,Math.floor(30/Math.max(this.perPixel,1e-9)/s[0])),r=performance.now(),l=i.createFramebuffer(),h=i.createRenderbuffer(),p=i.createRenderbuffer();i.bindFramebuffer(i.FRAMEBUFFER,l);for(let[m,d,x]of[[h,i.RGBA8,i.COLOR_ATTACHMENT0],[p,i.DEPTH_COMPONENT24,i.DEPTH_ATTACHMENT]])i.bindRenderbuffer(i.RENDERBUFFER,m),i.renderbufferStorage(i.RENDERBUFFER,d,...s),i.framebufferRenderbuffer(i.FRAMEBUFFER,x,i.RENDERBUFFER,m);i.bindFramebuffer(i.FRAMEBUFFER,null);let c=()=>{i.deleteFramebuffer(l),i.deleteRenderbuffer(h),i.deleteRenderbuffer(p)},u=s[1],f=()=>{if(this.wish!==t||!this.scene)return c();let m=u;if(u=Math.max(0,u-o),i.bindFramebuffer(i.FRAMEBUFFER,l),this.strip(s,u,m,e),this.wait(u),i.bindFramebuffer(i.FRAMEBUFFER,null),u>0)return setTimeout(f,0);[this.canvas.width,this.canvas.height]=n,i.bindFramebuffer(i.READ_FRAMEBUFFER,l),i.blitFramebuffer(0,0,...s,0,0,...n,i.COLOR_BUFFER_BIT,e>1?i.LINEAR:i.NEAREST),i.bindFramebuffer(i.READ_FRAMEBUFFER,null),c();let d=performance.now()-r;this.told(`${n[0]} x ${n[1]}${e>1?`, ${e*e} samples`:""}, ${d.toFixed(0)} ms`),!(e>1)&&(this.drawn+=1,this.canvas.dataset.drawn=this.drawn,d<400&&this.refines&&this.full(t,2))};f()}strip(t,e,i,n){let s=this.gl,o=this.scene,r=this.camera.uniforms(Math.hypot(...o.hi.map((c,u)=>c-o.lo[u]))),l=Math.max(...[...r.eye,...o.lo,...o.hi].map(Math.abs)),h=Math.hypot(...o.lo.map((c,u)=>Math.max(Math.abs(c-r.eye[u]),Math.abs(o.hi[u]-r.eye[u]))));s.viewport(0,0,...t),s.enable(s.SCISSOR_TEST),s.scissor(0,e,t[0],i-e),s.clearColor(0,0,0,0),s.clearDepth(1),s.clear(s.COLOR_BUFFER_BIT|s.DEPTH_BUFFER_BIT),s.enable(s.DEPTH_TEST),s.depthFunc(s.LEQUAL),s.disable(s.BLEND);let p=2**-23*l;for(let c of o.bodies)this.body(c,r,t,n,h,p);o.plane&&this.section.axis>=0&&(s.enable(s.BLEND),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA),this.plane(o,r,t,h,p)),s.disable(s.SCISSOR_TEST)}body(t,e,i,n,s,o){let r=[...t.lo],l=[...t.hi],h=[0,0,0],p=[0,0,0],{axis:c,offset:u,keeps:f}=this.section;if(c>=0){if(f>0?u>=l[c]:u<=r[c])return;f>0&&u>r[c]&&(r[c]=u,h[c]=1),f<0&&u<l[c]&&(l[c]=u,p[c]=1)}let m=Math.hypot(...t.hi.map((v,w)=>v-t.lo[w])),d=t.lo.map((v,w)=>(v+t.hi[w])/2),x=e.camera.slice(6),b=e.perspective?Math.max(1e-9,d.reduce((v,w,U)=>v+(w-e.eye[U])*x[U],0)):1,R=2*e.zoom*b/i[1],_=Math.hypot(...e.eye.map((v,w)=>v-d[w]))+m,C=Math.max(.2*R,1e-6*_,4*o);this.draw(t,e,i,{want:[1,"i",0],samples:[1,"i",n],side:[1,"f",1],layer:[1,"f",0],rounding:[1,"f",o],nearest:[1,"f",C],finest:[1,"f",Math.max(.01*R,1e-7*_,o)],jump:[1,"f",Math.max(.5*R,C)],reach:[1,"f",.1*m],grain:[1,"f",Math.max(.5*R,1e-5*_,32*o)],corner:[2,"f",[0,0]],farthest:[1,"f",s],box_lo:[3,"f",r],box_hi:[3,"f",l],cells_lo:[3,"f",t.lo],cells_hi:[3,"f",t.hi],cut_lo:[3,"f",h],cut_hi:[3,"f",p],counts:[3,"i",t.counts],material:[3,"f",t.colour],section:[3,"f",t.section]})}plane(t,e,i,n,s){let{axis:o,offset:r}=this.section;this.draw(t.plane,e,i,{box_lo:[3,"f",t.lo],box_hi:[3,"f",t.hi],axis:[1,"i",o],offset:[1,"f",r],farthest:[1,"f",n],nearer:[1,"f",Math.max(2e-6*n,8*s)],every:[1,"f",t.scale.every],clear:[1,"f",.45]})}draw(t,e,i,n){let s=this.gl,{program:o,places:r}=this.programs.get(t.text),l=c=>(r.has(c)||r.set(c,s.getUniformLocation(o,c)),r.get(c));s.useProgram(o),t.units.forEach(([c,u,f],m)=>{s.activeTexture(s.TEXTURE0+m),s.bindTexture(c,u),s.uniform1i(l(f),m)}),t.numbers.length&&s.uniform1fv(l("u"),t.numbers);let h=this.scene.scale;h&&(s.uniform3fv(l("scale_colours"),h.colours.flat()),s.uniform3fv(l("scale_ends"),h.ends));let p={zoom:[1,"f",e.zoom],perspective:[1,"f",e.perspective],size:[2,"f",i],eye:[3,"f",e.eye]};for(let[c,[u,f,m]]of Object.entries({...p,...n}))u===1?s[`uniform1${f}`](l(c),m):s[`uniform${u}${f}v`](l(c),m);s.uniformMatrix3fv(l("camera"),!1,e.camera),s.drawArrays(s.TRIANGLES,0,3)}};var N=["x","y","z"],A=class{constructor(t,e,{stats:i=!1,refines:n=!0,keys:s={}}={}){this.root=t,this.ask=e,this.element=o=>t.getElementById(o),this.canvas=this.element("view"),this.camera=new T,this.told={text:"",scene:"",export:"",measure:""},this.doings=new Map,this.state={program:null,settings:{},outputs:[],paint:"",plane:!1,scene:null,fitted:""},this.waiting=new Map;try{this.painter=new S(this.canvas,this.camera,o=>{this.element("stats").hidden=!i,this.element("stats").textContent=o}),this.painter.refines=n}catch(o){this.painter=null,this.wrong("scene",o.message)}this.section=this.painter?.section??{axis:-1,offset:0,keeps:1},this.resized=new ResizeObserver(()=>this.moved()),this.resized.observe(this.canvas),$(this,s),this.buttons()}buttons(){let{element:t}=this;t("said-shut").onclick=()=>{t("said").hidden=!0},Object.keys(y).forEach((e,i)=>{let n=g("button",{textContent:e,title:String(i+1)});n.onclick=()=>this.stand(e),t("views").append(n)}),t("fit").onclick=()=>this.fit(),t("projection").onclick=()=>this.project();for(let[e,i]of[[-1,"none"],...N.entries()]){let n=g("button",{textContent:i,id:`across-${i}`});n.onclick=()=>this.cross(e),t("axes").append(n)}t("offset").oninput=()=>this.cutAt(Number(t("offset").value)),t("offset-number").oninput=()=>this.cutAt(parseFloat(t("offset-number").value)),t("flip").onclick=()=>{this.section.keeps*=-1,this.ask.cut(this.section),this.moved()},t("plane").onclick=()=>{this.state.plane=!this.state.plane,this.across(),this.show()},t("paint").onchange=()=>{this.state.paint=t("paint").value.trim(),this.show()},t("presets").onchange=()=>{t("presets").value&&this.ask.preset(t("presets").value)},t("defaults").onclick=()=>this.ask.preset("")}wrong(t,e){this.told[t]=e;let i=Object.values(this.told).filter(Boolean).join(`

`);this.element("said-text").textContent=i,this.element("said").hidden=!i}doing(t,e,i){let{element:n,doings:s}=this;e?s.set(t,{what:e,share:i}):s.delete(t);let[o,r]=[...s].find(([l])=>l!=="measure")??[];n("doing").hidden=!r,r&&(n("doing-what").textContent=r.what,n("doing-share").hidden=r.share===void 0,n("doing-share").value=r.share??0,n("stop").hidden=o!=="scene"&&o!=="export",n("stop").onclick=()=>this.ask.cancel(o))}heard(t){let{say:e,of:i}=t;e==="scene"?this.take(t):e==="program"?this.programmed(t):e==="doing"?this.doing(i,t.what,t.share):e==="done"?this.doing(i,""):e==="refused"&&this.wrong(i,t.text)}moved(){this.painter?.moved()}take(t){let{state:e}=this;this.doing("scene","compiling the shader"),this.painter?.take(t,i=>{if(this.doing("scene",""),this.wrong("scene",i),i)return;e.scene=t;let n=t.bodies.map(s=>s.name).join(" ");this.canvas.dataset.outputs=n,e.fitted!==n&&this.fit(),e.fitted=n,D(this.element("legend"),t.scale),this.across(),this.listed(),this.moved()})}fit(){let{scene:t}=this.state,{canvas:e}=this;t&&(this.camera.fit(t.lo,t.hi,e.clientWidth/e.clientHeight),this.moved())}stand(t){[this.camera.azimuth,this.camera.elevation]=y[t],this.fit()}project(){this.camera.perspective=!this.camera.perspective,this.element("projection").setAttribute("aria-pressed",String(!this.camera.perspective)),this.moved()}cross(t){let{section:e,state:{scene:i}}=this;!this.painter||!i||(t>=0&&t!==e.axis&&(e.offset=(i.lo[t]+i.hi[t])/2,e.keeps=this.camera.axes().out[t]>0?-1:1),e.axis=t,this.ask.cut(e),this.across(),this.show(),this.moved())}across(){let{element:t,section:{axis:e,offset:i},state:{scene:n,plane:s}}=this;N.concat("none").forEach(o=>t(`across-${o}`).setAttribute("aria-pressed",String(o===(N[e]??"none")))),t("section-more").hidden=e<0,t("plane").setAttribute("aria-pressed",String(s)),!(e<0||!n)&&(Object.assign(t("offset"),{min:n.lo[e],max:n.hi[e]}),t("offset").value=i,this.root.activeElement!==t("offset-number")&&(t("offset-number").value=E(i)))}cutAt(t){let{section:e,state:{scene:i}}=this,{axis:n}=e;n<0||!Number.isFinite(t)||(e.offset=Math.min(Math.max(t,i.lo[n]),i.hi[n]),this.ask.cut(e),this.across(),this.moved())}slide(t,e){let{camera:i,section:{axis:n,offset:s}}=this;if(n<0)return;let{right:o,up:r}=i.axes(),l=Math.max(.05,o[n]**2+r[n]**2);this.cutAt(s+(t*o[n]-e*r[n])/l*i.height/this.canvas.clientHeight)}step(t){let{section:{axis:e,offset:i},state:{scene:n}}=this;e>=0&&this.cutAt(i+t*(n.hi[e]-n.lo[e])/100)}cutSo({axis:t,offset:e,keeps:i}){Object.assign(this.section,t<0?{axis:t}:{axis:t,offset:e,keeps:i}),this.across(),this.moved()}set(t,e){this.state.settings[t]=e,this.waiting.size||requestAnimationFrame(()=>{this.ask.set(Object.fromEntries(this.waiting)),this.waiting.clear()}),this.waiting.set(t,e)}put(t){Object.assign(this.state.settings,t);let e=this.element("params").children;this.state.program?.params.forEach(({name:i},n)=>{i in t&&e[n].put(t[i])})}show(){let{outputs:t,paint:e,plane:i}=this.state;this.ask.show({outputs:t,paint:e,plane:i&&this.section.axis>=0})}listed(){let{element:t,state:e}=this,i=e.program?.bodies??[];if(t("outputs").hidden=i.length<2,i.length<2)return;let n=e.scene?.bodies??[],s=n.map(r=>r.name),o=new Map(n.map(r=>[r.name,r.colour]));t("outputs").replaceChildren(g("h2",{textContent:"Outputs"}),...I(i,s,o,r=>{e.outputs=r,this.show()}))}programmed(t){let{element:e,state:i}=this,n=this.root.activeElement?.id;i.program=t,e("file").textContent=t.file,this.wrong("text",t.wrong.join(`

`)),i.settings=Object.fromEntries(t.params.filter(s=>s.value!==s.default).map(s=>[s.name,s.value])),e("params-all").hidden=!t.params.length,e("params").replaceChildren(...t.params.map(s=>P(s,(o,r)=>this.set(o,r)))),e("presets").hidden=!t.presets.length,e("presets").replaceChildren(new Option("preset ...",""),...t.presets.map(s=>new Option(s))),e("fields").replaceChildren(...t.fields.map(s=>g("option",{value:s}))),this.listed(),n&&e(n)?.focus({preventScroll:!0})}close(){this.resized.disconnect(),this.painter?.end()}};function j(a){let t=new DataView(a).getUint32(0,!0),e=JSON.parse(new TextDecoder().decode(new Uint8Array(a,4,t))),i=4+t,n=(s,o)=>(i+=4*o,new s(a,i-4*o,o));for(let s of z(e))s.numbers=new Float32Array(s.numbers),s.counts&&(s.cells=n(Float32Array,s.counts[0]*s.counts[1]*s.counts[2])),s.data=s.words.map(o=>n(Uint32Array,o));return{say:"scene",...e}}var z=a=>[...a.bodies,...a.plane?[a.plane]:[]],F=class{constructor(){this.known=[]}forget(){this.known=[]}into(t){z(t).forEach((e,i)=>{e.text??=this.known[t.plane===e?"plane":i]}),this.known=t.bodies.map(e=>e.text),this.known.plane=t.plane?.text}};var B=`<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>porelang</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="page.css">
</head>
<body>
<section id="source" aria-label="Program" hidden>
  <div class="bar">
    <strong id="state" role="status"></strong>
    <span class="room"></span>
    <button id="style" title="Alt-Shift-F">Format</button>
    <button id="save" title="Ctrl-S">Save</button>
    <button id="shut" aria-label="Hide the program">\xD7</button>
  </div>
  <div id="conflict" role="alert" hidden>
    Another program has changed the file.
    <button id="theirs">Take what is on disk</button> <button id="ours">Save this over it</button>
  </div>
  <div id="editor"></div>
</section>
<main>
  <canvas id="view" tabindex="0" role="application" aria-label="The part. Arrow keys turn it, with Alt they move the section; plus and minus zoom, F fits it, digits 1 to 7 choose a view, O changes the projection."></canvas>
  <div id="legend" role="img" hidden></div>
  <div id="doing" role="status" hidden><span id="doing-what"></span> <progress id="doing-share" max="1"></progress> <button id="stop">Cancel</button></div>
  <div id="stats" hidden></div>
  <div id="said" role="alert" hidden><button id="said-shut" aria-label="Close this message">\xD7</button><pre id="said-text"></pre></div>
</main>
<aside aria-label="Settings">
  <header><h1 id="file">porelang</h1><button id="open" aria-pressed="false" title="E">Program</button></header>
  <section id="outputs" aria-label="Outputs" hidden></section>
  <section aria-label="Params" id="params-all" hidden>
    <div class="row"><select id="presets" aria-label="Preset" hidden></select><button id="defaults">Defaults</button></div>
    <div id="params"></div>
  </section>
  <section aria-label="Section">
    <h2>Section</h2>
    <div class="row" id="axes" role="group" aria-label="Section across"></div>
    <div id="section-more" hidden>
      <input type="range" id="offset" aria-label="Offset of the section" step="any">
      <div class="row"><input type="number" id="offset-number" aria-label="Offset of the section in mm" step="any"> <span class="quiet">mm</span>
        <button id="flip">Flip</button> <button id="plane" aria-pressed="false">Field on it</button></div>
    </div>
  </section>
  <section aria-label="Colour">
    <h2><label for="paint">Colour by</label></h2>
    <input id="paint" list="fields" placeholder="nothing, or a field: z, stress, ..." autocomplete="off" spellcheck="false">
    <datalist id="fields"></datalist>
  </section>
  <section aria-label="View">
    <h2>View</h2>
    <div class="row" id="views"></div>
    <div class="row"><button id="fit" title="F">Fit</button> <button id="projection" title="O" aria-pressed="false">Parallel</button></div>
  </section>
  <section aria-label="Measures" id="measures" aria-live="polite" hidden>
    <h2 id="measures-head">Measures</h2>
    <dl id="rows"></dl>
    <ul id="checks"></ul>
  </section>
  <section aria-label="Export">
    <h2>Export</h2>
    <div class="row">
      <select id="ending" aria-label="Format"></select>
      <label class="quiet" for="voxel">voxel</label> <input id="voxel" value="auto" size="6" spellcheck="false">
      <button id="export">Mesh</button> <button id="picture">Picture</button>
    </div>
    <div id="made"></div>
  </section>
  <section id="doubts" aria-label="Warnings" hidden></section>
  <footer>Drag turns, Shift-drag or the right button moves, the wheel zooms, Alt-drag moves the section.</footer>
</aside>
<script type="module" src="page.js"><\/script>
</body>
</html>
`;var q=`:root, :host {
  color-scheme: light dark;
  --ground: #ffffff; --panel: #f6f6f4; --text: #22231f; --quiet: #63655e; --line: #d5d5ce; --accent: #9a4d27;
  --wrong: #9c1c1c; --wrong-ground: #fff4f2; --well: #2f6b3a;
}
@media (prefers-color-scheme: dark) {
  :root, :host {
    --ground: #1b1c1a; --panel: #242522; --text: #e9e8e2; --quiet: #a8a79f; --line: #44453f; --accent: #e39a70;
    --wrong: #ffb4a8; --wrong-ground: #3a1f1b; --well: #9ad0a0;
  }
}
* { box-sizing: border-box; }
html, body { height: 100%; margin: 0; }
body { display: flex; background: var(--ground); color: var(--text); font: 14px/1.45 system-ui, sans-serif; }
main { flex: 1 1 40%; position: relative; min-width: 0; min-height: 0; overflow: hidden; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { outline: 2px solid var(--accent); outline-offset: -2px; }
#source { flex: 1 1 34%; min-width: 260px; max-width: 60%; display: flex; flex-direction: column; border-right: 1px solid var(--line); resize: horizontal; overflow: hidden; }
#editor { flex: 1; min-height: 0; overflow: hidden; }
#editor > * { height: 100%; }
.bar { display: flex; gap: 6px; align-items: center; padding: 6px 10px; background: var(--panel); border-bottom: 1px solid var(--line); }
.bar strong { font-weight: 600; overflow-wrap: anywhere; }
.room { flex: 1; }
#conflict { padding: 8px 10px; color: var(--wrong); background: var(--wrong-ground); }
aside { flex: none; width: 304px; overflow-y: auto; background: var(--panel); border-left: 1px solid var(--line); padding: 14px 16px; }
aside header { display: flex; gap: 8px; align-items: baseline; justify-content: space-between; margin-bottom: 10px; }
h1 { font-size: 16px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 12px; font-weight: 600; color: var(--quiet); margin: 16px 0 6px; }
.param { margin: 0 0 14px; }
.param .name { display: flex; justify-content: space-between; gap: 8px; align-items: baseline; }
.param label { font-weight: 600; overflow-wrap: anywhere; }
.param .doc { color: var(--quiet); font-size: 12px; margin: 1px 0 3px; }
input[type=range] { width: 100%; accent-color: var(--accent); margin: 2px 0; padding: 0; }
.box { display: flex; align-items: baseline; gap: 4px; color: var(--quiet); }
input[type=number] { width: 84px; text-align: right; }
#paint { width: 100%; }
input, select, button { font: inherit; color: inherit; background: var(--ground); border: 1px solid var(--line); border-radius: 4px; padding: 2px 6px; }
.param select { width: 100%; }
button { padding: 3px 9px; cursor: pointer; }
button:hover { border-color: var(--accent); }
button:disabled { opacity: .5; cursor: default; }
button[aria-pressed=true] { border-color: var(--accent); color: var(--accent); }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
.row { display: flex; flex-wrap: wrap; gap: 6px; margin-bottom: 6px; align-items: baseline; }
.quiet { color: var(--quiet); }
#outputs label { display: flex; gap: 8px; align-items: center; padding: 2px 0; }
.swatch { width: 12px; height: 12px; border-radius: 3px; border: 1px solid var(--line); }
#said { position: absolute; left: 16px; right: 16px; bottom: 16px; max-height: 60%; overflow: auto; padding: 12px 16px;
  color: var(--wrong); background: var(--wrong-ground); border: 1px solid currentColor; border-radius: 6px; }
#said pre { margin: 0; white-space: pre-wrap; font: 13px/1.45 ui-monospace, monospace; }
#said button { float: right; border: 0; background: none; padding: 0 4px; font-size: 18px; line-height: 1; }
#doing, #stats { position: absolute; right: 12px; top: 12px; padding: 3px 10px; border-radius: 12px; font-size: 12px; color: var(--quiet);
  background: var(--panel); border: 1px solid var(--line); }
#doing { display: flex; gap: 8px; align-items: center; }
#doing progress { width: 80px; accent-color: var(--accent); }
#doing button { padding: 0 8px; }
#stats { right: auto; left: 12px; font-variant-numeric: tabular-nums; }
#legend { position: absolute; left: 14px; top: 44px; font-size: 12px; pointer-events: none; font-variant-numeric: tabular-nums; }
#legend .what { margin-bottom: 6px; background: color-mix(in srgb, var(--ground) 70%, transparent); }
#legend .scale { position: relative; height: 180px; }
#legend canvas { position: static; width: 14px; height: 180px; border: 1px solid var(--line); }
#legend .tick { position: absolute; left: 20px; transform: translateY(-50%); white-space: nowrap; }
dl { display: grid; grid-template-columns: auto 1fr; gap: 2px 10px; margin: 0; }
dt { color: var(--quiet); }
dd { margin: 0; text-align: right; font-variant-numeric: tabular-nums; }
#checks { list-style: none; padding: 0; margin: 8px 0 0; }
#checks li.holds { color: var(--well); }
#checks li.fails { color: var(--wrong); }
#checks .quiet { font-size: 12px; padding-left: 16px; }
#made a { color: var(--accent); overflow-wrap: anywhere; }
#doubts { white-space: pre-wrap; font: 12px/1.4 ui-monospace, monospace; color: var(--quiet); border-top: 1px solid var(--line); padding-top: 12px; margin-top: 16px; overflow-x: auto; }
footer { color: var(--quiet); font-size: 12px; margin-top: 20px; }
[hidden] { display: none !important; }
@media (max-width: 900px) { #source { max-width: 45%; min-width: 200px; } aside { width: 240px; } }
@media (max-width: 640px) { body { flex-direction: column; } #source { max-width: none; min-height: 30%; border-right: 0; border-bottom: 1px solid var(--line); } main { min-height: 40%; } aside { width: auto; max-height: 40%; border-left: 0; border-top: 1px solid var(--line); } }
`;var H=`:host { display: block; container-type: inline-size; width: 100%; }
.frame { display: flex; height: var(--height, 460px); background: var(--ground); color: var(--text); font: 14px/1.45 system-ui, sans-serif;
  border: 1px solid var(--line); border-radius: 4px; overflow: hidden; }
#panel { width: 264px; }
#panel[inert] { opacity: 0.5; }
#still { position: absolute; inset: 0; width: 100%; height: 100%; object-fit: contain; }
@container (max-width: 520px) {
  .frame { flex-direction: column; height: auto; }
  main { flex: none; height: var(--height, 460px); }
  #panel { width: auto; border-left: 0; border-top: 1px solid var(--line); }
}
`;var W="xyz",et="The kernel that this belongs to has been restarted: run the cell again. The picture is the last one.",Mt=()=>{let a=new Set,t=new F,e={},i=!1;return{initialize({model:n}){let s=()=>{i=!0;for(let r of a)r.lost(i)},o=(r,l)=>{if(i){i=!1;for(let h of a)h.lost(i)}if(r.say==="scene"){let{buffer:h,byteOffset:p,byteLength:c}=l[0];r=j(h.slice(p,p+c)),t.into(r)}["program","scene"].includes(r.say)&&(e[r.say]=r),r.say==="refused"&&(e[`refused ${r.of}`]=r),r.say==="scene"&&delete e["refused scene"];for(let h of a)h.heard(X(r))};return n.on("msg:custom",o),n.on("comm_live_update",s),n.send({do:"begin"}),()=>{n.off("msg:custom",o),n.off("comm_live_update",s)}},render({model:n,el:s}){let o=document.createElement("div"),r=o.attachShadow({mode:"open"});s.append(o);let l=[it(o,r),nt(r,n)],h=d=>{for(let[x,b]of Object.entries(d))n.set(x,b);n.save_changes()},p=new A(r,{set:d=>h({settings:{...n.get("settings"),...d}}),show:h,preset:d=>n.send({do:"preset",name:d}),cancel:()=>n.send({do:"cancel"}),cut:d=>h({cut:G(d)})}),{state:c,element:u}={state:p.state,element:p.element},f={settings:d=>p.put(d),outputs:d=>{c.outputs=d},paint:d=>{c.paint=d,r.activeElement!==u("paint")&&(u("paint").value=d)},height:d=>o.style.setProperty("--height",`${d}px`),plane:d=>{c.plane=d,d&&c.scene&&p.section.axis<0&&p.cross(1),p.across()},cut:d=>{d!==G(p.section)&&p.cutSo(st(d))}};for(let[d,x]of Object.entries(f)){let b=()=>x(n.get(d));n.on(`change:${d}`,b),l.push(()=>n.off(`change:${d}`,b))}f.height(n.get("height"));let m={lost(d){u("panel").inert=d,p.wrong("kernel",d?et:"")},heard(d){if(d.say==="program"&&(u("panel").hidden=!1),p.heard(d),d.say==="program")for(let[x,b]of Object.entries(f))b(n.get(x));d.say==="scene"&&(p.wrong("scene",""),c.plane&&f.plane(!0))}};a.add(m);for(let d of[e.program,e.scene])d&&m.heard(X(d));for(let d of Object.values(e))d.say==="refused"&&m.heard(d);return i&&m.lost(i),()=>{a.delete(m),p.close();for(let d of l)d()}}}};function X(a){return a.say!=="scene"?a:{...a,bodies:a.bodies.map(t=>({...t})),plane:a.plane&&{...a.plane}}}function G({axis:a,offset:t,keeps:e}){return a<0?"":`${W[a]}${e>0?"<":">"}${Number(t.toPrecision(6))}`}function st(a){return{axis:W.indexOf(a[0]??"-"),offset:Number(a.slice(2)),keeps:a[1]==="<"?1:-1}}function it(a,t){let e=[q,H].map(p=>{let c=new CSSStyleSheet;return c.replaceSync(p),c});t.adoptedStyleSheets=e;let i=new DOMParser().parseFromString(B,"text/html"),n=i.querySelector("main"),s=i.querySelector("aside");for(let p of s.querySelectorAll("#open, #measures, #doubts, [aria-label=Export]"))p.remove();Object.assign(s,{id:"panel",hidden:!0});let o=document.createElement("div");o.className="frame",o.append(n,s),t.append(o);let r=matchMedia("(prefers-color-scheme: dark)"),l=()=>{let{jpThemeLight:p,vscodeThemeKind:c}=document.body.dataset,u=p?p==="false":c?/dark$|contrast$/.test(c):r.matches;a.style.colorScheme=u?"dark":"light";for(let f of e[0].cssRules)f.media&&[...f.cssRules].some(m=>m.style?.getPropertyValue("--ground"))&&(f.media.mediaText=u?"all":"not all")};l();let h=new MutationObserver(l);return h.observe(document.body,{attributes:!0,attributeFilter:["data-jp-theme-light","data-vscode-theme-kind"]}),r.addEventListener("change",l),()=>{h.disconnect(),r.removeEventListener("change",l)}}function nt(a,t){let e=document.createElement("img");e.id="still",e.alt="The part",a.querySelector("main").prepend(e);let i="",n=()=>{let o=t.get("still");URL.revokeObjectURL(i),i=o?.byteLength?URL.createObjectURL(new Blob([o],{type:"image/png"})):"",e.hidden=!i,i&&(e.src=i)};n(),t.on("change:still",n);let s=new MutationObserver(()=>{e.hidden=!0});return s.observe(a.getElementById("view"),{attributes:!0,attributeFilter:["data-outputs"]}),()=>{t.off("change:still",n),s.disconnect(),URL.revokeObjectURL(i)}}export{Mt as default};
